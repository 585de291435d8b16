/* Rays against the patches: one traversal of an 8-wide bounding volume hierarchy, for closest and for any hit.

   Node, 8 rows of 8 words: lowest x of 8 boxes, highest x, lowest y, highest y, lowest z, highest z, references,
   unused. Leaf, 10 rows: x of the first corners of 8 triangles, of the second, of the third, the same for y and z,
   names. A reference is the number of a node, or HR_BVH_LEAF | number of a leaf. Leaf 0 has no triangle; references
   of missing children point to it. Children that block most rays for their size come last. A name is
   2 patch + half; half 1 of a parallelogram is (p0 + eu + ev, p0 + ev, p0 + eu).
   All coordinates are float32 relative to the structure's local origin. */
#ifndef HR_BVH_H
#define HR_BVH_H

#include "include/hr_lanes.h"
#include "include/hr_types.h"

#define HR_BVH_LEAF 0x80000000u
#define HR_BVH_NODE_ROWS 8ul
#define HR_BVH_LEAF_ROWS 10ul
#define HR_BVH_STACK 160 /* the builder keeps 7 levels + 8 below this */
#define HR_BVH_NOTHING 0xFFFFFFFFFFFFFFFFul

/* Not inlined, since PoCL would keep the stack of each work-item of a group apart, and they would not fit in cache. */
#define HR_NO_INLINE __attribute__((noinline))
#define HR_ROW_ALIGNED __attribute__((aligned(32)))

typedef struct {
    uint patch; /* HR_NONE: a miss */
    uint side;  /* 0: front, where dot(direction, edge_u x edge_v) < 0; 1: back */
    float t;    /* in lengths of the direction; INFINITY for a miss */
    float u;    /* the point is origin + u edge_u + v edge_v of the patch */
    float v;
} hr_hit;

#define HR_BVH_PARAMS                                                                                                  \
    __global const float *bvh_nodes,     /* (n_nodes, 64)  [m], references by bits */                                  \
        __global const float *bvh_leaves /* (n_leaves, 80) [m], names by bits */
#define HR_BVH bvh_nodes, bvh_leaves

/* p moved along the unit normal n by 2^-20 of the coordinates' size, so that rounding can't put it behind its patch.
   scale: the scene's largest half extent. */
HR_FORCE_INLINE float3 hr_offset_origin(float3 p, float3 n, float scale)
{
    const float own = hr_largest_magnitude(p);
    return p + (0x1p-20f * (own > scale ? own : scale)) * n;
}

/* 1/d, or a large number with the sign of d where d is 0 or 1/d would overflow. */
HR_FORCE_INLINE float hr_finite_reciprocal(float d)
{
    return 1.0f / (hr_magnitude(d) >= 1e-18f ? d : d < 0.0f ? -1e-18f : 1e-18f);
}

/* What the traversal keeps of one ray.

   Boxes are widened for the rounding of the triangle test, which is relative to the distance of the corners from
   the origin: the builder widens them by the scene's size, and the ray moves its origin forward for the near planes
   and back for the far ones. That also covers the three roundings of the slab test (Ize 2013), and with the finite
   reciprocal there is no 0 * infinity where a ray runs inside a box's plane. */
typedef struct {
    float3 near_origin;
    float3 far_origin;
    float3 reciprocal;
    uint near_x, near_y, near_z;        /* rows of the near planes in a node; the far ones are beside them */
    uint x, y, z;                       /* first rows of the sheared axes in a leaf */
    float origin_x, origin_y, origin_z; /* origin along them */
    float shear_x, shear_y, shear_z;
} hr_ray;

HR_FORCE_INLINE void hr_prepare_ray(float3 origin, float3 direction, hr_ray *ray)
{
    const float step = 0x1p-20f * hr_largest_magnitude(origin);
    ray->reciprocal.x = hr_finite_reciprocal(direction.x);
    ray->reciprocal.y = hr_finite_reciprocal(direction.y);
    ray->reciprocal.z = hr_finite_reciprocal(direction.z);
    const int3 backward = ray->reciprocal < 0.0f;
    const float3 forward_step = backward ? (float3)(-step) : (float3)(step);
    ray->near_origin = origin + forward_step;
    ray->far_origin = origin - forward_step;
    ray->near_x = backward.x ? 1u : 0u;
    ray->near_y = backward.y ? 3u : 2u;
    ray->near_z = backward.z ? 5u : 4u;

    /* The axis along which the direction is longest becomes z; the other two keep the triangles' winding. */
    const uint z = hr_main_axis(direction);
    const float length = hr_component(direction, z);
    const uint next = z == 2u ? 0u : z + 1u;
    const uint last = 3u - z - next;
    const uint x = length < 0.0f ? last : next;
    const uint y = length < 0.0f ? next : last;
    ray->x = 3u * x;
    ray->y = 3u * y;
    ray->z = 3u * z;
    ray->origin_x = hr_component(origin, x);
    ray->origin_y = hr_component(origin, y);
    ray->origin_z = hr_component(origin, z);
    ray->shear_x = hr_component(direction, x) / length;
    ray->shear_y = hr_component(direction, y) / length;
    ray->shear_z = 1.0f / length;
}

/* Which of a node's 8 boxes the ray meets in [0, t_max], and from where on. */
HR_FORCE_INLINE uint hr_boxes_met(__global const float8 *node, const hr_ray *ray, float t_max, float8 *near)
{
    const float8 near_x = (node[ray->near_x] - ray->near_origin.x) * ray->reciprocal.x;
    const float8 near_y = (node[ray->near_y] - ray->near_origin.y) * ray->reciprocal.y;
    const float8 near_z = (node[ray->near_z] - ray->near_origin.z) * ray->reciprocal.z;
    const float8 far_x = (node[ray->near_x ^ 1u] - ray->far_origin.x) * ray->reciprocal.x;
    const float8 far_y = (node[ray->near_y ^ 1u] - ray->far_origin.y) * ray->reciprocal.y;
    const float8 far_z = (node[ray->near_z ^ 1u] - ray->far_origin.z) * ray->reciprocal.z;
    const float8 leave = hr_smaller8(hr_smaller8(far_x, far_y), hr_smaller8(far_z, (float8)(t_max)));
    *near = hr_larger8(hr_larger8(near_x, near_y), hr_larger8(near_z, (float8)(0.0f)));
    return hr_lanes(*near <= leave);
}

/* Distances t, weights of the second and third corner times det, and det of the 8 triangles of a leaf; returns which
   are met in (0, t_max].
   Woop, Benthin, Wald 2013: corners are sheared so that the ray is the z axis; the signs of the three edge functions
   then decide. Neighbours get the same edge function but for the sign, so no ray passes between them; a zero belongs
   to both. det > 0 where the ray meets the front.
   Where the ray runs in a triangle's plane all three are what rounding left, and may agree however far away the ray
   passes: it has to pass inside the bounds of the sheared corners as well. */
HR_FORCE_INLINE uint hr_triangles_met(__global const float8 *leaf, const hr_ray *ray, float t_max, float8 *t,
                                      float8 *second, float8 *third, float8 *det)
{
    __global const float8 *x = leaf + ray->x;
    __global const float8 *y = leaf + ray->y;
    __global const float8 *z = leaf + ray->z;
    const float8 az = z[0] - ray->origin_z;
    const float8 bz = z[1] - ray->origin_z;
    const float8 cz = z[2] - ray->origin_z;
    const float8 ax = x[0] - ray->origin_x - ray->shear_x * az;
    const float8 bx = x[1] - ray->origin_x - ray->shear_x * bz;
    const float8 cx = x[2] - ray->origin_x - ray->shear_x * cz;
    const float8 ay = y[0] - ray->origin_y - ray->shear_y * az;
    const float8 by = y[1] - ray->origin_y - ray->shear_y * bz;
    const float8 cy = y[2] - ray->origin_y - ray->shear_y * cz;
    const float8 u = cx * by - cy * bx;
    const float8 v = ax * cy - ay * cx;
    const float8 w = bx * ay - by * ax;
    const float8 lowest = hr_smaller8(hr_smaller8(u, v), w);
    const float8 highest = hr_larger8(hr_larger8(u, v), w);
    const float8 sum = u + v + w;
    int8 inside = ((lowest >= 0.0f) | (highest <= 0.0f)) & (sum != 0.0f);
    if (!hr_lanes(inside))
        return 0u;
    inside &= (hr_smaller8(hr_smaller8(ax, bx), cx) <= 0.0f) & (hr_larger8(hr_larger8(ax, bx), cx) >= 0.0f);
    inside &= (hr_smaller8(hr_smaller8(ay, by), cy) <= 0.0f) & (hr_larger8(hr_larger8(ay, by), cy) >= 0.0f);
    *t = (u * az + v * bz + w * cz) * ray->shear_z / sum;
    *second = v;
    *third = w;
    *det = sum;
    return hr_lanes(inside & (*t > 0.0f) & (*t <= t_max));
}

/* Keeps the nearest hit among a leaf's triangles, of hits at the same t that of the lowest patch. */
HR_FORCE_INLINE void hr_visit_leaf(__global const float8 *leaf, const hr_ray *ray, uint skip_a, uint skip_b,
                                   hr_hit *best)
{
    float8 t, second, third, det;
    uint met = hr_triangles_met(leaf, ray, best->t, &t, &second, &third, &det);
    if (!met)
        return;
    HR_ROW_ALIGNED float ts[8], seconds[8], thirds[8], dets[8];
    *(float8 *)ts = t;
    *(float8 *)seconds = second;
    *(float8 *)thirds = third;
    *(float8 *)dets = det;
    __global const uint *names = (__global const uint *)(leaf + 9);
    for (; met; met &= met - 1u) {
        const uint lane = hr_lowest_bit(met);
        const uint patch = names[lane] >> 1;
        const int nearer = ts[lane] < best->t || (ts[lane] == best->t && patch < best->patch);
        if (!nearer || patch == skip_a || patch == skip_b)
            continue;
        const float b1 = seconds[lane] / dets[lane];
        const float b2 = thirds[lane] / dets[lane];
        const int is_second_half = names[lane] & 1u;
        best->patch = patch;
        best->side = dets[lane] > 0.0f ? 0u : 1u;
        best->t = ts[lane];
        best->u = is_second_half ? 1.0f - b1 : b1;
        best->v = is_second_half ? 1.0f - b2 : b2;
    }
}

/* Entry of the stack: where a child begins and its reference, ordered by the first. */
HR_FORCE_INLINE ulong hr_entry(float near, uint reference)
{
    return (ulong)as_uint(near) << 32 | reference;
}

/* Puts the children met on the stack but for the one to go on with, which is returned: the nearest, for any hit the
   last, which the builder chose. HR_BVH_NOTHING where none is met. Sorting the others does not pay. */
HR_FORCE_INLINE ulong hr_visit_node(__global const float8 *node, const hr_ray *ray, float t_max, const int any_hit,
                                    ulong *stack, uint *height)
{
    float8 near;
    uint met = hr_boxes_met(node, ray, t_max, &near);
    if (!met)
        return HR_BVH_NOTHING;
    HR_ROW_ALIGNED float nears[8];
    *(float8 *)nears = near;
    __global const uint *references = (__global const uint *)(node + 6);
    uint lane = hr_lowest_bit(met);
    ulong next = hr_entry(nears[lane], references[lane]);
    for (met &= met - 1u; met; met &= met - 1u) {
        lane = hr_lowest_bit(met);
        const ulong other = hr_entry(nears[lane], references[lane]);
        const int keep = !any_hit && next < other;
        stack[(*height)++] = keep ? other : next;
        next = keep ? next : other;
    }
    return next;
}

/* The traversal. any_hit is a constant at each of its two calls. *best becomes the nearest hit, or with any_hit the
   first one found. */
HR_FORCE_INLINE void hr_traverse(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_a,
                                 uint skip_b, const int any_hit, hr_hit *best)
{
    best->patch = HR_NONE;
    best->side = 0u;
    best->t = INFINITY;
    best->u = 0.0f;
    best->v = 0.0f;
    if (!(t_max > 0.0f))
        return;
    /* t_max is exclusive; everything inside compares with the largest number below it. */
    best->t = as_float(as_uint(t_max) - 1u);
    hr_ray ray;
    hr_prepare_ray(origin, direction, &ray);
    ulong stack[HR_BVH_STACK];
    uint height = 0u;
    ulong entry = 0ul; /* the root */
    while (true) {
        const uint reference = (uint)entry;
        if (reference & HR_BVH_LEAF) {
            hr_visit_leaf((__global const float8 *)bvh_leaves + HR_BVH_LEAF_ROWS * (reference & ~HR_BVH_LEAF), &ray,
                          skip_a, skip_b, best);
            if (any_hit && best->patch != HR_NONE)
                return;
            entry = HR_BVH_NOTHING;
        } else {
            entry = hr_visit_node((__global const float8 *)bvh_nodes + HR_BVH_NODE_ROWS * reference, &ray, best->t,
                                  any_hit, stack, &height);
        }
        while (entry == HR_BVH_NOTHING) {
            if (height == 0u) {
                best->t = best->patch == HR_NONE ? INFINITY : best->t;
                return;
            }
            const ulong top = stack[--height];
            if (any_hit || as_float((uint)(top >> 32)) <= best->t)
                entry = top;
        }
    }
}

/* First patch that the ray meets in (0, t_max), skip_patch left out (HR_NONE: none). */
HR_NO_INLINE hr_hit hr_closest_hit(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_patch)
{
    hr_hit hit;
    hr_traverse(HR_BVH, origin, direction, t_max, skip_patch, HR_NONE, 0, &hit);
    return hit;
}

/* 1 if the ray meets anything in (0, t_max), the patches skip_a and skip_b left out (HR_NONE: none). */
HR_NO_INLINE int hr_any_hit(HR_BVH_PARAMS, float3 origin, float3 direction, float t_max, uint skip_a, uint skip_b)
{
    hr_hit hit;
    hr_traverse(HR_BVH, origin, direction, t_max, skip_a, skip_b, 1, &hit);
    return hit.patch != HR_NONE;
}

#endif
