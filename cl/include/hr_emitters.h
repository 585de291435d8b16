/* Emitting patches and point sources. */
#ifndef HR_EMITTERS_H
#define HR_EMITTERS_H

#include "include/hr_form_factor.h"

#define HR_EMITTER_PARAMS                                                                     \
    __global const uint *emitter_patch,     /* (n_emitters,) HR_NONE: a point source       */ \
    __global const float *emitter_position, /* (n_emitters, 3) [m], centre                 */ \
    __global const float *emitter_extent,   /* (n_emitters, 2) area [m^2], diameter [m]    */ \
    __global const uint *emitter_two_sided  /* (n_emitters,) 1: shines from its back too   */
#define HR_EMITTER emitter_patch, emitter_position, emitter_extent, emitter_two_sided

/* Distance from the emitter, in its diameters, beyond which samples of the kernel hardly differ. */
#define HR_FAR 3.0f

/* Area of an area emitter that is far from x, else 0. */
HR_FORCE_INLINE float hr_far_area(const float3 x, const uint emitter, HR_EMITTER_PARAMS)
{
    const float area = emitter_extent[2 * emitter];
    const float diameter = emitter_extent[2 * emitter + 1];
    const float3 d = hr_load3(emitter_position, emitter) - x;
    return hr_dot(d, d) >= HR_FAR * HR_FAR * diameter * diameter ? area : 0.0f;
}

/* Unit normal of the side of an emitting patch that looks at x; the front if only that shines. */
HR_FORCE_INLINE float3 hr_emitter_normal(const uint patch, const uint two_sided, const float3 x, HR_PATCH_PARAMS)
{
    const float3 m = hr_load3(patch_normal, patch);
    const int behind = hr_dot(m, x - hr_load3(patch_origin, patch)) < 0.0f;
    return behind && two_sided ? -m : m;
}

/* Irradiance at the point x with unit normal n, without obstacles, for unit exitance of the emitter [1], or for unit
   intensity of a point source [m^-2]. `patch` is HR_NONE for a point source. */
HR_FORCE_INLINE float hr_emitter_factor(const float3 x, const float3 n, const uint emitter, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    if (patch != HR_NONE)
        return hr_point_to_patch(x, n, patch, hr_emitter_normal(patch, emitter_two_sided[emitter], x, HR_PATCH),
                                 HR_PATCH);
    const float3 d = hr_load3(emitter_position, emitter) - x;
    const float r2 = hr_larger(hr_dot(d, d), 1.0e-30f);
    return hr_larger(hr_dot(n, d), 0.0f) / (r2 * sqrt(r2));
}

/* Point (s, t) of the unit square on the emitter. */
HR_FORCE_INLINE float3 hr_emitter_point(const uint emitter, const float s, const float t, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    if (patch == HR_NONE)
        return hr_load3(emitter_position, emitter);
    const float2 uv = patch_kind[patch] ? hr_square_to_triangle(s, t) : (float2)(s, t);
    return hr_patch_point(patch, uv.x, uv.y, HR_PATCH);
}

/* Weight of the ray from x to the point y of the emitter, what it would bring if nothing stood in its way:
   cos cos / (pi r^2) [m^-2], and cos / r^2 [m^-2] for a point source. */
HR_FORCE_INLINE float hr_emitter_weight(const float3 x, const float3 n, const float3 y, const uint emitter, HR_EMITTER_PARAMS,
                               HR_PATCH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    if (patch == HR_NONE)
        return hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    return hr_point_kernel(n, y - x, hr_emitter_normal(patch, emitter_two_sided[emitter], x, HR_PATCH));
}

/* What the point y of a near area emitter counts when points drawn on the emitter and directions drawn by the cosine
   law are combined by the balance heuristic (Veach & Guibas 1995): p_cos / (p_area + p_cos) = k A / (1 + k A) with k
   the point kernel. Never above 1, however near the emitter is. */
HR_FORCE_INLINE float hr_balanced_weight(const float3 x, const float3 n, const float3 y, const uint emitter,
                                         HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const float sent = hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH) * emitter_extent[2 * emitter];
    return sent / (1.0f + sent);
}

/* Distance along the unit direction d at which the ray from x meets the shining side of an area emitter; 0 if it does
   not. */
HR_FORCE_INLINE float hr_aimed_at(const float3 x, const float3 d, const uint emitter, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    const float3 m = hr_emitter_normal(patch, emitter_two_sided[emitter], x, HR_PATCH);
    const float facing = hr_dot(m, d);
    const float3 r0 = hr_load3(patch_origin, patch) - x;
    if (facing >= 0.0f || hr_dot(m, r0) >= 0.0f)
        return 0.0f;
    const float t = hr_dot(m, r0) / facing;
    const float3 p = t * d - r0;
    const float3 eu = hr_load3(patch_edge_u, patch);
    const float3 ev = hr_load3(patch_edge_v, patch);
    const float3 c = hr_cross(eu, ev);
    const float scale = 1.0f / hr_dot(c, c);
    const float u = hr_dot(hr_cross(p, ev), c) * scale;
    const float v = hr_dot(hr_cross(eu, p), c) * scale;
    const float last = patch_kind[patch] ? 1.0f - u : 1.0f;
    return u >= 0.0f && v >= 0.0f && u <= 1.0f && v <= last ? t : 0.0f;
}

/* What the ray from x along d, which ended at distance t_end on the patch `met`, adds to the gain from a near emitter
   one point of which was tried: the second half of the balance heuristic. With `clear` its closed form counts, and what
   is found hidden is taken off; else what is found open is added. */
HR_FORCE_INLINE float hr_found_on_ray(const float3 x, const float3 n, const float3 d, const uint met, const float t_end,
                                      const uint emitter, const int clear, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const float t = hr_aimed_at(x, d, emitter, HR_EMITTER, HR_PATCH);
    if (t <= 0.0f)
        return 0.0f;
    const int hidden = met != emitter_patch[emitter] && t_end < t;
    if (hidden != clear)
        return 0.0f;
    const float weight = hr_balanced_weight(x, n, x + t * d, emitter, HR_EMITTER, HR_PATCH);
    return hidden ? -weight : weight;
}

#endif
