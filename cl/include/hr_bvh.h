/* Rays against the patches: one traversal of an 8-wide bounding volume hierarchy, for closest and for any hit.

   Node, 64 words: lowest x of 8 boxes, highest x, lowest y, highest y, lowest z, highest z, 8 references, 8 unused.
   Leaf, 80 words: x, y, z of the first corners of 8 triangles, of the second, of the third, 8 names.
   A reference is the number of a node, or HR_BVH_LEAF | number of a leaf. Leaf 0 has no triangle; references of
   missing children point to it. A name is 2 patch + half; half 1 is (p0 + eu + ev, p0 + ev, p0 + eu).
   All coordinates are float32 relative to the structure's local origin. */
#ifndef HR_BVH_H
#define HR_BVH_H

#include "include/hr_types.h"

#define HR_BVH_LEAF 0x80000000u
#define HR_BVH_NODE_WORDS 64u
#define HR_BVH_LEAF_WORDS 80u

/* The builder keeps 7 depth + 8 below this. */
#ifndef HR_BVH_STACK
#define HR_BVH_STACK 160
#endif

typedef struct {
    uint patch; /* HR_NONE: a miss */
    uint side;  /* 0: front, where dot(direction, edge_u x edge_v) < 0; 1: back */
    float t;    /* in lengths of the direction; INFINITY for a miss */
    float u;    /* the point is origin + u edge_u + v edge_v of the patch */
    float v;
} hr_hit;

#define HR_BVH_PARAMS                                                                                                  \
    __global const float *bvh_nodes,      /* (n_nodes, 64)  [m], references by bits */                                 \
        __global const float *bvh_leaves  /* (n_leaves, 80) [m], names by bits */
#define HR_BVH bvh_nodes, bvh_leaves

/* p moved along the unit normal n by 2^-20 of the coordinates' size, so that rounding can't put it behind its patch.
   scale: the scene's largest half extent. */
inline float3 hr_offset_origin(float3 p, float3 n, float scale)
{
    const float size = fmax(fmax(fmax(fabs(p.x), fabs(p.y)), fabs(p.z)), scale);
    return p + (0x1p-20f * size) * n;
}

/* The same through comparisons, which compile to one instruction where fmax and fmin do not. */
inline float8 hr_larger8(float8 a, float8 b)
{
    return a > b ? a : b;
}

inline float8 hr_smaller8(float8 a, float8 b)
{
    return a < b ? a : b;
}

/* One bit for each true lane. */
inline uint hr_lanes(int8 truth)
{
    const int8 bits = truth & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 fours = bits.lo | bits.hi;
    const int2 twos = fours.lo | fours.hi;
    return (uint)(twos.x | twos.y);
}

/* Number of the lowest set bit. bits must not be 0. */
inline uint hr_lowest_bit(uint bits)
{
    return popcount((bits & (0u - bits)) - 1u);
}

/* Largest of the three magnitudes: 0, 1 or 2. */
inline uint hr_main_axis(float3 v)
{
    const float3 a = fabs(v);
    return a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 1u : 2u;
}

inline float hr_component(float3 v, uint axis)
{
    return axis == 0u ? v.x : axis == 1u ? v.y : v.z;
}

/* 1/d, finite with the sign of d where d is 0 or so small that 1/d would overflow. */
inline float hr_finite_reciprocal(float d)
{
    return 1.0f / (fabs(d) < 1e-18f ? (d < 0.0f ? -1e-18f : 1e-18f) : d);
}

/* What the traversal keeps of one ray.

   Boxes are widened for the rounding of the triangle test, which is relative to the distance of the corners from
   the origin: the builder widens them by the scene's size, and the ray moves its origin forward for the near planes
   and back for the far ones. It covers the three roundings of the slab test (Ize 2013), and keeps 0 * (1/0) away. */
typedef struct {
    float3 near_origin;
    float3 far_origin;
    float3 reciprocal;
    uint near_x, near_y, near_z; /* word offsets of the near planes in a node */
    uint x, y, z;                /* word offsets of the sheared axes in a leaf */
    float origin_x, origin_y, origin_z; /* origin along them */
    float shear_x, shear_y, shear_z;
} hr_ray_setup;

inline hr_ray_setup hr_prepare_ray(float3 origin, float3 direction)
{
    hr_ray_setup ray;
    const float size = fmax(fmax(fabs(origin.x), fabs(origin.y)), fabs(origin.z));
    ray.reciprocal = (float3)(hr_finite_reciprocal(direction.x), hr_finite_reciprocal(direction.y),
                              hr_finite_reciprocal(direction.z));
    const float3 step = copysign((float3)(0x1p-20f * size), ray.reciprocal);
    ray.near_origin = origin + step;
    ray.far_origin = origin - step;
    ray.near_x = ray.reciprocal.x < 0.0f ? 8u : 0u;
    ray.near_y = ray.reciprocal.y < 0.0f ? 24u : 16u;
    ray.near_z = ray.reciprocal.z < 0.0f ? 40u : 32u;

    /* The axis along which the direction is longest becomes z; the other two keep the triangles' winding. */
    const uint z = hr_main_axis(direction);
    const float length = hr_component(direction, z);
    const uint next = z == 2u ? 0u : z + 1u;
    const uint last = 3u - z - next;
    const uint x = length < 0.0f ? last : next;
    const uint y = length < 0.0f ? next : last;
    ray.x = 8u * x;
    ray.y = 8u * y;
    ray.z = 8u * z;
    ray.origin_x = hr_component(origin, x);
    ray.origin_y = hr_component(origin, y);
    ray.origin_z = hr_component(origin, z);
    ray.shear_x = hr_component(direction, x) / length;
    ray.shear_y = hr_component(direction, y) / length;
    ray.shear_z = 1.0f / length;
    return ray;
}

/* Which of a node's 8 boxes the ray meets within (0, t_max], and from where on. */
inline uint hr_boxes_met(__global const float *node, const hr_ray_setup *ray, float t_max, float8 *near)
{
    const float8 near_x = (vload8(0, node + ray->near_x) - ray->near_origin.x) * ray->reciprocal.x;
    const float8 near_y = (vload8(0, node + ray->near_y) - ray->near_origin.y) * ray->reciprocal.y;
    const float8 near_z = (vload8(0, node + ray->near_z) - ray->near_origin.z) * ray->reciprocal.z;
    const float8 far_x = (vload8(0, node + (8u - ray->near_x)) - ray->far_origin.x) * ray->reciprocal.x;
    const float8 far_y = (vload8(0, node + (40u - ray->near_y)) - ray->far_origin.y) * ray->reciprocal.y;
    const float8 far_z = (vload8(0, node + (72u - ray->near_z)) - ray->far_origin.z) * ray->reciprocal.z;
    const float8 enter = hr_larger8(hr_larger8(near_x, near_y), hr_larger8(near_z, (float8)(0.0f)));
    const float8 leave = hr_smaller8(hr_smaller8(far_x, far_y), hr_smaller8(far_z, (float8)(t_max)));
    *near = enter;
    return hr_lanes(enter <= leave);
}

/* Distances and barycentric weights of the 8 triangles of a leaf; returns which are met within (0, t_max].
   Woop, Benthin, Wald 2013: corners are sheared so that the ray is the z axis; the signs of the three edge functions
   then decide. Neighbours get an edge function of the same magnitude, so no ray passes between them. A zero belongs
   to both neighbours. det > 0 where the ray meets the front. */
inline uint hr_triangles_met(__global const float *leaf, const hr_ray_setup *ray, float t_max, float8 *t, float8 *b1,
                             float8 *b2, float8 *det)
{
    const float8 az = vload8(0, leaf + ray->z) - ray->origin_z;
    const float8 bz = vload8(0, leaf + 24u + ray->z) - ray->origin_z;
    const float8 cz = vload8(0, leaf + 48u + ray->z) - ray->origin_z;
    const float8 ax = vload8(0, leaf + ray->x) - ray->origin_x - ray->shear_x * az;
    const float8 bx = vload8(0, leaf + 24u + ray->x) - ray->origin_x - ray->shear_x * bz;
    const float8 cx = vload8(0, leaf + 48u + ray->x) - ray->origin_x - ray->shear_x * cz;
    const float8 ay = vload8(0, leaf + ray->y) - ray->origin_y - ray->shear_y * az;
    const float8 by = vload8(0, leaf + 24u + ray->y) - ray->origin_y - ray->shear_y * bz;
    const float8 cy = vload8(0, leaf + 48u + ray->y) - ray->origin_y - ray->shear_y * cz;
    const float8 u = cx * by - cy * bx;
    const float8 v = ax * cy - ay * cx;
    const float8 w = bx * ay - by * ax;
    const float8 lowest = hr_smaller8(hr_smaller8(u, v), w);
    const float8 highest = hr_larger8(hr_larger8(u, v), w);
    *det = u + v + w;
    const int8 inside = ((lowest >= 0.0f) | (highest <= 0.0f)) & (*det != 0.0f);
    if (!any(inside))
        return 0u;
    *t = (u * az + v * bz + w * cz) * ray->shear_z / *det;
    *b1 = v;
    *b2 = w;
    return hr_lanes(inside & (*t > 0.0f) & (*t <= t_max));
}

/* The traversal. any_hit is a constant at each of its two calls. t_max is exclusive. */
inline hr_hit hr_traverse(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_a, uint skip_b,
                          const int any_hit)
{
    const hr_ray_setup ray = hr_prepare_ray(origin, direction);
    uint stack[HR_BVH_STACK];
    float stack_near[HR_BVH_STACK];
    uint height = 0u;
    uint reference = 0u;
    hr_hit best = {HR_NONE, 0u, t_max, 0.0f, 0.0f};
    while (true) {
        if (reference & HR_BVH_LEAF) {
            __global const float *leaf = bvh_leaves + (ulong)HR_BVH_LEAF_WORDS * (reference & ~HR_BVH_LEAF);
            float8 t, b1, b2, det;
            uint met = hr_triangles_met(leaf, &ray, best.t, &t, &b1, &b2, &det);
            if (met) {
                float ts[8], b1s[8], b2s[8], dets[8];
                vstore8(t, 0, ts);
                vstore8(b1, 0, b1s);
                vstore8(b2, 0, b2s);
                vstore8(det, 0, dets);
                do {
                    const uint lane = hr_lowest_bit(met);
                    met &= met - 1u;
                    const uint name = as_uint(leaf[72u + lane]);
                    const uint patch = name >> 1;
                    if (patch == skip_a || patch == skip_b || ts[lane] > best.t ||
                        (ts[lane] == best.t && patch >= best.patch) || !(ts[lane] < t_max))
                        continue;
                    const float first = b1s[lane] / dets[lane];
                    const float second = b2s[lane] / dets[lane];
                    best.patch = patch;
                    best.side = dets[lane] > 0.0f ? 0u : 1u;
                    best.t = ts[lane];
                    best.u = name & 1u ? 1.0f - first : first;
                    best.v = name & 1u ? 1.0f - second : second;
                    if (any_hit)
                        return best;
                } while (met);
            }
        } else {
            __global const float *node = bvh_nodes + (ulong)HR_BVH_NODE_WORDS * reference;
            float8 near;
            uint met = hr_boxes_met(node, &ray, best.t, &near);
            float nears[8];
            vstore8(near, 0, nears);
            const uint base = height;
            while (met) {
                const uint lane = hr_lowest_bit(met);
                met &= met - 1u;
                uint place = height;
                if (!any_hit)
                    for (; place > base && stack_near[place - 1u] < nears[lane]; place--) {
                        stack[place] = stack[place - 1u];
                        stack_near[place] = stack_near[place - 1u];
                    }
                stack[place] = as_uint(node[48u + lane]);
                stack_near[place] = nears[lane];
                height++;
            }
        }
        do {
            if (height == 0u) {
                best.t = best.patch == HR_NONE ? INFINITY : best.t;
                return best;
            }
            height--;
        } while (!any_hit && stack_near[height] > best.t);
        reference = stack[height];
    }
}

/* First patch that the ray meets in (0, t_max), skip_patch left out; of patches at the same t the lowest. */
inline hr_hit hr_closest_hit(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_patch)
{
    return hr_traverse(HR_BVH, origin, direction, t_max, skip_patch, HR_NONE, 0);
}

/* 1 if the ray meets anything in (0, t_max), the patches skip_a and skip_b left out (HR_NONE: none). */
inline int hr_any_hit(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_a, uint skip_b)
{
    return hr_traverse(HR_BVH, origin, direction, t_max, skip_a, skip_b, 1).patch != HR_NONE;
}

#endif
