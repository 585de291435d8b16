/* What a point receives from a flat patch: closed forms and quadrature. */
#ifndef HR_FORM_FACTOR_H
#define HR_FORM_FACTOR_H

#include "include/hr_patches.h"

/* atan2(y, x) for y >= 0. Polynomial of the Cephes library's atanf (Moshier); error below 2e-7.
   The driver's own atan2 is not vectorised and costs as much as a ray. */
HR_FORCE_INLINE float hr_atan2_upper(const float y, const float x)
{
    const float ax = hr_magnitude(x);
    const float large = hr_larger(ax, y);
    const float small = hr_smaller(ax, y);
    float t = large > 0.0f ? small / large : 0.0f;
    const int reduced = t > 0.41421356f;
    t = reduced ? (t - 1.0f) / (t + 1.0f) : t;
    const float z = t * t;
    float angle = (((8.05374449538e-2f * z - 1.38776856032e-1f) * z + 1.99777106478e-1f) * z - 3.33329491539e-1f) * z * t + t;
    angle = reduced ? angle + 0.25f * HR_PI : angle;
    angle = y > ax ? 0.5f * HR_PI - angle : angle;
    return x < 0.0f ? HR_PI - angle : angle;
}

/* n . c Theta / |c| of one edge: r from the point to the edge's start, e the edge itself, c = r x e.
   The edge vector keeps digits that the product of two end points would lose (Lambert's formula). */
HR_FORCE_INLINE float hr_edge_term(const float3 n, const float3 r, const float3 e)
{
    const float3 c = hr_cross(r, e);
    const float length_c = sqrt(hr_dot(c, c));
    const float d = hr_dot(r, r + e);
    if (length_c <= 1.0e-7f * hr_magnitude(d))
        return d > 0.0f ? hr_dot(n, c) / d : 0.0f;
    return hr_dot(n, c) * hr_atan2_upper(length_c, d) / length_c;
}

/* Form factor of the point with unit normal n to the polygon with corners r[k] (seen from the point), by Lambert's
   formula over the part above the horizon. Positive whatever the winding; rounding does not exceed 1. [1] */
HR_FORCE_INLINE float hr_polygon_factor(const float3 n, const float3 *r, const uint count)
{
    float sum = 0.0f;
    float3 first = (float3)(0.0f);
    float3 last = (float3)(0.0f);
    int started = 0;
    for (uint k = 0; k < count; ++k) {
        const float3 a = r[k];
        const float3 b = r[k + 1 == count ? 0 : k + 1];
        const float ha = hr_dot(n, a);
        const float hb = hr_dot(n, b);
        if (ha < 0.0f && hb < 0.0f)
            continue;
        const float3 start = ha >= 0.0f ? a : a + (ha / (ha - hb)) * (b - a);
        const float3 end = hb >= 0.0f ? b : a + (ha / (ha - hb)) * (b - a);
        if (started) {
            /* The polygon left the horizon at `last` and comes back at `start`. */
            const float3 along = start - last;
            if (hr_dot(along, along) > 0.0f)
                sum += hr_edge_term(n, last, along);
        } else {
            first = start;
            started = 1;
        }
        sum += hr_edge_term(n, start, end - start);
        last = end;
    }
    if (started) {
        const float3 along = first - last;
        if (hr_dot(along, along) > 0.0f)
            sum += hr_edge_term(n, last, along);
    }
    return hr_smaller(0.5f * HR_INV_PI * hr_magnitude(sum), 1.0f);
}

/* Lambert's formula when all corners are above the horizon, with the edges as given and not as differences. */
HR_FORCE_INLINE float hr_visible_polygon_factor(const float3 n, const float3 *r, const float3 *e, const uint count)
{
    float sum = 0.0f;
    for (uint k = 0; k < count; ++k)
        sum += hr_edge_term(n, r[k], e[k]);
    return hr_smaller(0.5f * HR_INV_PI * hr_magnitude(sum), 1.0f);
}

/* cos cos / (pi r^2) between a point with unit normal n and one at offset d with unit normal m. [m^-2] */
HR_FORCE_INLINE float hr_point_kernel(const float3 n, const float3 d, const float3 m)
{
    const float r2 = hr_dot(d, d);
    return hr_larger(hr_dot(n, d), 0.0f) * hr_larger(-hr_dot(m, d), 0.0f) * HR_INV_PI / hr_larger(r2 * r2, 1.0e-30f);
}

__constant float hr_gauss_node[9] = {0.21132487f, 0.78867513f, 0.11270167f, 0.5f, 0.88729833f,
                                     0.06943184f, 0.33000948f, 0.66999052f, 0.93056816f};
__constant float hr_gauss_weight[9] = {0.5f, 0.5f, 0.27777778f, 0.44444444f, 0.27777778f,
                                       0.17392742f, 0.32607258f, 0.32607258f, 0.17392742f};

/* Area rule with order x order Gauss points (order 2 to 4); triangles by Duffy's map. [1] */
HR_FORCE_INLINE float hr_area_rule(const float3 n, const float3 r0, const float3 eu, const float3 ev, const float3 m,
                          const uint triangle, const uint order)
{
    const uint offset = order == 2 ? 0 : order == 3 ? 2 : 5;
    const float3 cr = hr_cross(eu, ev);
    float sum = 0.0f;
    for (uint i = 0; i < order; ++i) {
        const float u = hr_gauss_node[offset + i];
        const float shrink = triangle ? 1.0f - u : 1.0f;
        for (uint j = 0; j < order; ++j) {
            const float v = hr_gauss_node[offset + j] * shrink;
            const float weight = hr_gauss_weight[offset + i] * hr_gauss_weight[offset + j] * shrink;
            sum += weight * hr_point_kernel(n, r0 + u * eu + v * ev, m);
        }
    }
    return sum * sqrt(hr_dot(cr, cr));
}

/* Heights above a plane below this share of the coordinates are rounding. */
#define HR_ON_PLANE 0x1p-21f

/* Form factor of the point x with unit normal n to one side of a patch, without obstacles. m: unit normal of that
   side. Chooses between Lambert's formula and the area rule by distance over size: the closed form loses all digits
   for small far polygons and for ones nearly in the receiver's plane. A point on the patch itself receives nothing
   from it; without a tolerance, rounding would decide between that and everything. [1] */
HR_FORCE_INLINE float hr_point_to_patch(const float3 x, const float3 n, const uint patch, const float3 m,
                                        HR_PATCH_PARAMS)
{
    const float3 eu = hr_load3(patch_edge_u, patch);
    const float3 ev = hr_load3(patch_edge_v, patch);
    const float3 r0 = hr_load3(patch_origin, patch) - x;
    const float rounding = HR_ON_PLANE * hr_larger(hr_largest_magnitude(x), hr_largest_magnitude(r0));
    if (-hr_dot(m, r0) <= rounding)
        return 0.0f;
    const uint triangle = patch_kind[patch];
    const float3 diagonal = triangle ? ev - eu : eu + ev;
    const float3 centre = r0 + (triangle ? 0.33333333f : 0.5f) * (eu + ev);
    const float size2 = hr_larger(hr_larger(hr_dot(eu, eu), hr_dot(ev, ev)), hr_dot(diagonal, diagonal));
    const float distance2 = hr_dot(centre, centre);
    const float3 r[4] = {r0, r0 + eu, triangle ? r0 + ev : r0 + eu + ev, r0 + ev};
    const float3 e[4] = {eu, triangle ? ev - eu : ev, triangle ? -ev : -eu, -ev};
    const uint count = triangle ? 3 : 4;
    const float h[4] = {hr_dot(n, r[0]), hr_dot(n, r[1]), hr_dot(n, r[2]), hr_dot(n, r[3])};
    const float lowest = hr_smaller(hr_smaller(h[0], h[1]), hr_smaller(h[2], h[3]));
    const float highest = hr_larger(hr_larger(h[0], h[1]), hr_larger(h[2], h[3]));
    if (highest <= 0.0f)
        return 0.0f;
    if (lowest >= -rounding) {
        if (distance2 >= 9.0f * size2)
            return hr_area_rule(n, r0, eu, ev, m, triangle, distance2 >= 256.0f * size2 ? 2 : 3);
        const float exact = hr_visible_polygon_factor(n, r, e, count);
        if (exact < 1.0e-3f && distance2 >= size2)
            return hr_area_rule(n, r0, eu, ev, m, triangle, 4);
        return exact;
    }
    return hr_polygon_factor(n, r, count);
}

#endif
