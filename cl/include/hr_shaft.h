/* Proof that nothing stands between a receiver and an emitter: triangles against the shaft, which is the convex hull of
   both (Haines & Wallace 1991, "Shaft Culling for Efficient Ray-Cast Radiosity").

   The hull is that of the points where shadow rays start, lifted off the receiver, and of the emitter. Every test finds
   a direction along which a triangle and the hull lie apart. Directions may be inexact: the intervals compared are
   those of the very corners, so that an ill-chosen direction proves nothing and never anything wrong.
   Touching is no blocking. Surfaces that touch may overlap by rounding, which `slack` allows along directions in which
   the hull is much thicker than that; where it is thin, two must be apart by as much. */
#ifndef HR_SHAFT_H
#define HR_SHAFT_H

#include "include/hr_bvh.h"
#include "include/hr_sight.h"

#define HR_SHAFT_PLANES 10u
#define HR_SHAFT_SLACK 0x1p-21f  /* of the coordinates' size: half of what ray origins are lifted by */
#define HR_SHAFT_MARGIN 0x1.8p-21f /* of the scene's half extent: a little less than boxes were widened by */
#define HR_SHAFT_BEHIND 0x1p-22f /* of the coordinates' size: rounding of a point on a plane */
#define HR_SHAFT_THICK 1024.0f   /* in slacks */

/* corner: 4 of the receiver, lifted, then 4 of the emitter; x, y, z the same in lanes.
   A point p with dot(n, p) <= level lies outside the plane of normal n. */
typedef struct {
    float3 corner[8];
    float8 x, y, z;
    float nx[HR_SHAFT_PLANES], ny[HR_SHAFT_PLANES], nz[HR_SHAFT_PLANES], level[HR_SHAFT_PLANES];
    uint n_planes;
    float slack;
    float box_slack;
    float3 low, high;
    float3 axis; /* from the receiver to the emitter */
} hr_shaft;

HR_FORCE_INLINE float hr_lowest4(float4 v)
{
    return hr_smaller(hr_smaller(v.x, v.y), hr_smaller(v.z, v.w));
}

HR_FORCE_INLINE float hr_highest4(float4 v)
{
    return hr_larger(hr_larger(v.x, v.y), hr_larger(v.z, v.w));
}

HR_FORCE_INLINE float8 hr_heights(const hr_shaft *shaft, const float3 n)
{
    return n.x * shaft->x + n.y * shaft->y + n.z * shaft->z;
}

HR_FORCE_INLINE void hr_keep_plane(hr_shaft *shaft, const float3 n, const float level)
{
    const uint k = shaft->n_planes++;
    shaft->nx[k] = n.x;
    shaft->ny[k] = n.y;
    shaft->nz[k] = n.z;
    shaft->level[k] = level;
}

/* The plane of normal n, of any length, moved out until it touches the hull; left out where n is 0. */
HR_FORCE_INLINE void hr_add_plane(hr_shaft *shaft, const float3 n)
{
    const float length2 = hr_dot(n, n);
    if (!(length2 > 1e-30f))
        return;
    const float3 unit_n = n * (1.0f / sqrt(length2));
    const float8 height = hr_heights(shaft, unit_n);
    const float low = hr_smaller(hr_lowest4(height.lo), hr_lowest4(height.hi));
    const float high = hr_larger(hr_highest4(height.lo), hr_highest4(height.hi));
    const int thick = high - low > HR_SHAFT_THICK * shaft->slack;
    hr_keep_plane(shaft, unit_n, thick ? low + shaft->slack : low - shaft->slack);
}

/* Planes through the edges of the polygon of corners `first` … `first` + 3 that touch the polygon of corners `other` …;
   turn: 1 where the corners run counter-clockwise seen from there, else -1. */
HR_FORCE_INLINE void hr_add_sides(hr_shaft *shaft, const uint first, const uint other, const float turn)
{
    for (uint k = 0; k < 4u; ++k) {
        const float3 a = shaft->corner[first + k];
        const float3 edge = turn * (shaft->corner[first + ((k + 1u) & 3u)] - a);
        float3 n = hr_cross(shaft->corner[other] - a, edge);
        for (uint j = 1; j < 4u; ++j) {
            const float3 to = shaft->corner[other + j] - a;
            if (hr_dot(n, to) < 0.0f)
                n = hr_cross(to, edge);
        }
        hr_add_plane(shaft, n);
    }
}

/* Whether some point of the receiver may be within `reach` of the emitter's centre. */
HR_FORCE_INLINE int hr_is_near(const hr_shaft *shaft, const float reach)
{
    const float3 *c = shaft->corner;
    const float3 centre = 0.25f * (c[0] + c[1] + c[2] + c[3]);
    const float3 apart = 0.25f * (c[4] + c[5] + c[6] + c[7]) - centre;
    float radius2 = 0.0f;
    for (uint k = 0; k < 4u; ++k)
        radius2 = hr_larger(radius2, hr_dot(c[k] - centre, c[k] - centre));
    const float limit = reach + sqrt(radius2);
    return hr_dot(apart, apart) <= limit * limit;
}

/* The hull's bounding planes but for the receiver's and the emitter's own. */
HR_FORCE_INLINE void hr_prepare_shaft(hr_shaft *shaft, const float turn)
{
    const float8 x = shaft->x, y = shaft->y, z = shaft->z;
    shaft->low = (float3)(hr_smaller(hr_lowest4(x.lo), hr_lowest4(x.hi)), hr_smaller(hr_lowest4(y.lo), hr_lowest4(y.hi)),
                          hr_smaller(hr_lowest4(z.lo), hr_lowest4(z.hi)));
    shaft->high = (float3)(hr_larger(hr_highest4(x.lo), hr_highest4(x.hi)), hr_larger(hr_highest4(y.lo), hr_highest4(y.hi)),
                           hr_larger(hr_highest4(z.lo), hr_highest4(z.hi)));
    shaft->axis = shaft->corner[4] + shaft->corner[6] - shaft->corner[0] - shaft->corner[2];
    hr_add_sides(shaft, 0u, 4u, 1.0f);
    hr_add_sides(shaft, 4u, 0u, turn);
}

/* Which of a node's 8 boxes reach into the shaft. */
HR_FORCE_INLINE uint hr_boxes_in_shaft(__global const float8 *node, const hr_shaft *shaft)
{
    int8 inside = (node[0] <= shaft->high.x) & (node[1] >= shaft->low.x) & (node[2] <= shaft->high.y) &
                  (node[3] >= shaft->low.y) & (node[4] <= shaft->high.z) & (node[5] >= shaft->low.z);
    for (uint k = 0; k < shaft->n_planes && hr_lanes(inside); ++k) {
        const float nx = shaft->nx[k], ny = shaft->ny[k], nz = shaft->nz[k];
        const float8 highest = nx * node[nx > 0.0f ? 1 : 0] + ny * node[ny > 0.0f ? 3 : 2] + nz * node[nz > 0.0f ? 5 : 4];
        inside &= highest > shaft->level[k] + shaft->box_slack;
    }
    return hr_lanes(inside);
}

/* Whether the hull and each of 8 triangles lie apart along the directions n, of any length. */
HR_FORCE_INLINE int8 hr_apart(__global const float8 *leaf, const hr_shaft *shaft, const float8 nx, const float8 ny,
                              const float8 nz)
{
    const float8 a = nx * leaf[0] + ny * leaf[3] + nz * leaf[6];
    const float8 b = nx * leaf[1] + ny * leaf[4] + nz * leaf[7];
    const float8 c = nx * leaf[2] + ny * leaf[5] + nz * leaf[8];
    float8 low = nx * shaft->corner[0].x + ny * shaft->corner[0].y + nz * shaft->corner[0].z;
    float8 high = low;
    for (uint k = 1; k < 8u; ++k) {
        const float8 h = nx * shaft->corner[k].x + ny * shaft->corner[k].y + nz * shaft->corner[k].z;
        low = hr_smaller8(low, h);
        high = hr_larger8(high, h);
    }
    const float8 size_x = nx < 0.0f ? -nx : nx;
    const float8 size_y = ny < 0.0f ? -ny : ny;
    const float8 size_z = nz < 0.0f ? -nz : nz;
    const float8 most = size_x + size_y + size_z; /* from above, the length of n */
    const float8 least = hr_larger8(size_x, hr_larger8(size_y, size_z));
    const float8 slack = high - low > HR_SHAFT_THICK * shaft->slack * most ? shaft->slack * least : -shaft->slack * most;
    const float8 lowest = hr_smaller8(a, hr_smaller8(b, c));
    const float8 highest = hr_larger8(a, hr_larger8(b, c));
    return (least > 1e-30f) & ((low >= highest - slack) | (high <= lowest + slack));
}

/* Whether any of a leaf's triangles may reach into the shaft; those of the patches own and lamp do not count. */
HR_FORCE_INLINE int hr_leaf_in_shaft(__global const float8 *leaf, const hr_shaft *shaft, const uint own, const uint lamp)
{
    const uint8 name = as_uint8(leaf[9]);
    int8 inside = (name != HR_NONE) & ((name >> 1) != own) & ((name >> 1) != lamp);
    for (uint k = 0; k < shaft->n_planes && hr_lanes(inside); ++k) {
        const float nx = shaft->nx[k], ny = shaft->ny[k], nz = shaft->nz[k];
        const float8 a = nx * leaf[0] + ny * leaf[3] + nz * leaf[6];
        const float8 b = nx * leaf[1] + ny * leaf[4] + nz * leaf[7];
        const float8 c = nx * leaf[2] + ny * leaf[5] + nz * leaf[8];
        inside &= hr_larger8(a, hr_larger8(b, c)) > shaft->level[k];
    }
    if (!hr_lanes(inside))
        return 0;
    float8 ex[3], ey[3], ez[3];
    for (uint k = 0; k < 3u; ++k) {
        const uint next = k == 2u ? 0u : k + 1u;
        ex[k] = leaf[next] - leaf[k];
        ey[k] = leaf[3 + next] - leaf[3 + k];
        ez[k] = leaf[6 + next] - leaf[6 + k];
    }
    inside &= ~hr_apart(leaf, shaft, ey[0] * ez[1] - ez[0] * ey[1], ez[0] * ex[1] - ex[0] * ez[1],
                        ex[0] * ey[1] - ey[0] * ex[1]);
    const float3 axis = shaft->axis;
    for (uint k = 0; k < 3u && hr_lanes(inside); ++k)
        inside &= ~hr_apart(leaf, shaft, ey[k] * axis.z - ez[k] * axis.y, ez[k] * axis.x - ex[k] * axis.z,
                            ex[k] * axis.y - ey[k] * axis.x);
    return hr_lanes(inside) != 0u;
}

/* Whether nothing but the patches own and lamp reaches into the shaft. Gives up, with 0, after most_visits nodes and
   leaves. */
HR_FORCE_INLINE int hr_is_empty(HR_BVH_PARAMS, const hr_shaft *shaft, const uint own, const uint lamp,
                                const uint most_visits)
{
    uint stack[HR_BVH_STACK];
    uint height = 1u;
    stack[0] = 0u; /* the root */
    for (uint visits = 0; height > 0u; ++visits) {
        if (visits == most_visits)
            return 0;
        const uint reference = stack[--height];
        if (reference & HR_BVH_LEAF) {
            if (hr_leaf_in_shaft((__global const float8 *)bvh_leaves + HR_BVH_LEAF_ROWS * (reference & ~HR_BVH_LEAF),
                                 shaft, own, lamp))
                return 0;
            continue;
        }
        __global const float8 *node = (__global const float8 *)bvh_nodes + HR_BVH_NODE_ROWS * reference;
        __global const uint *references = (__global const uint *)(node + 6);
        for (uint met = hr_boxes_in_shaft(node, shaft); met; met &= met - 1u)
            stack[height++] = references[hr_lowest_bit(met)];
    }
    return 1;
}

/* What can be said for sure about the sight between a flat receiver with unit normal n, corners counter-clockwise seen
   from its light side, and an emitter with unit normal m (0: a point source). Points repeat their one corner. Whether
   the sight is free is tried where some point of the receiver may be within `reach` of the emitter's centre [m]. */
HR_NO_INLINE uint hr_sight(HR_BVH_PARAMS, const float3 *receiver_corner, const float3 n, const uint own,
                           const float3 *emitter_corner, const float3 m, const uint lamp, const uint two_sided,
                           const float scale, const float reach, const uint most_visits)
{
    hr_shaft shaft;
    float size = scale;
    for (uint k = 0; k < 4u; ++k) {
        const float3 r = receiver_corner[k];
        const float3 e = emitter_corner[k];
        size = hr_larger(size, hr_larger(hr_largest_magnitude(r), hr_largest_magnitude(e)));
        shaft.corner[k] = hr_offset_origin(r, n, scale);
        shaft.corner[4 + k] = e;
    }
    const float3 *c = shaft.corner;
    shaft.x = (float8)(c[0].x, c[1].x, c[2].x, c[3].x, c[4].x, c[5].x, c[6].x, c[7].x);
    shaft.y = (float8)(c[0].y, c[1].y, c[2].y, c[3].y, c[4].y, c[5].y, c[6].y, c[7].y);
    shaft.z = (float8)(c[0].z, c[1].z, c[2].z, c[3].z, c[4].z, c[5].z, c[6].z, c[7].z);
    shaft.n_planes = 0u;
    shaft.slack = HR_SHAFT_SLACK * size;
    shaft.box_slack = HR_SHAFT_MARGIN * scale;
    const float behind = HR_SHAFT_BEHIND * size;
    const float lift = 2.0f * shaft.slack;

    const float8 above = hr_heights(&shaft, n);
    const float ground = hr_lowest4(above.lo);
    if (hr_highest4(above.hi) <= ground - lift + behind)
        return HR_SIGHT_HIDDEN;
    /* Rays start lifted and go up: what rises less than half as far over the receiver's plane is below them. */
    hr_keep_plane(&shaft, n, ground - 0.5f * lift);

    float turn = 1.0f;
    if (hr_dot(m, m) > 0.0f) {
        const float8 before = hr_heights(&shaft, m);
        const float lamp_low = hr_lowest4(before.hi), lamp_high = hr_highest4(before.hi);
        const float raised = lift * hr_dot(m, n);
        if (hr_highest4(before.lo) - raised <= lamp_low + behind) {
            if (!two_sided)
                return HR_SIGHT_HIDDEN;
            turn = -1.0f;
            hr_keep_plane(&shaft, -m, -lamp_high + shaft.slack);
        } else if (!two_sided || hr_lowest4(before.lo) - raised >= lamp_high - behind) {
            hr_keep_plane(&shaft, m, lamp_low + shaft.slack);
        }
    }
    if (!hr_is_near(&shaft, reach))
        return HR_SIGHT_UNKNOWN;
    hr_prepare_shaft(&shaft, turn);
    return hr_is_empty(HR_BVH, &shaft, own, lamp, most_visits) ? HR_SIGHT_FREE : HR_SIGHT_UNKNOWN;
}

#endif
