/* Direct light: closed-form factor times sampled visibility. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"

/* Is the way from x (unit normal n, on patch `own`) to the point y of the emitter free? */
HR_FORCE_INLINE float hr_open(const float3 x, const float3 n, const uint own, const float3 y, const uint emitter_patch,
                     const float scale, HR_BVH_PARAMS)
{
    const float3 origin = hr_offset_origin(x, n, scale);
    return hr_any_hit(HR_BVH, origin, y - origin, 1.0f, own, emitter_patch) ? 0.0f : 1.0f;
}

/* Mean factor of each row's exposed points to each emitter, times the kernel-weighted share of open rays. The points
   are the origins of the row's own exchange rays, so that both see the same part of the element. From afar the mean
   factor is estimated by the same kernel samples, which costs a third of the closed form. */
__kernel void direct_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                          __global const uint *hit_row, /* (n_rows, n_samples), from trace_rows          */
                          __global float *direct,       /* (n_rows, n_emitters) [1] or [m^-2]            */
                          const uint n_samples, const uint n_points, const uint n_emitters, const uint occlusion,
                          const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = i / n_emitters;
    const uint emitter = i % n_emitters;
    const uint row_seed = hr_combine(seed, row);
    const uint lamp_seed = hr_combine(row_seed, emitter);
    float factor = 0.0f, weight = 0.0f, open = 0.0f;
    uint exposed = 0;
    for (uint k = 0; k < n_samples && exposed < n_points; ++k) {
        if (hit_row[row * n_samples + k] == HR_COVERED)
            continue;
        ++exposed;
        const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed),
                                               HR_ELEMENT, HR_PATCH);
        if (place.patch == emitter_patch[emitter])
            continue;
        const float3 y = hr_emitter_point(emitter, hr_sample(k, 2, lamp_seed), hr_sample(k, 3, lamp_seed),
                                          HR_EMITTER, HR_PATCH);
        const float w = hr_emitter_weight(place.position, place.normal, y, emitter, HR_EMITTER, HR_PATCH);
        const float far_area = hr_far_area(place.position, emitter, HR_EMITTER);
        factor += far_area > 0.0f
                      ? far_area * w
                      : hr_emitter_factor(place.position, place.normal, emitter, HR_EMITTER, HR_PATCH);
        weight += w;
        if (w > 0.0f)
            open += occlusion ? w * hr_open(place.position, place.normal, place.patch, y, emitter_patch[emitter],
                                            scale, HR_BVH)
                              : w;
    }
    direct[i] = weight > 0.0f ? (factor / (float)exposed) * (open / weight) : 0.0f;
}

/* The same at single points. After `n_pilot` rays that all agree, the emitter counts as wholly open or hidden. */
__kernel void direct_points(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                            __global const float *position, /* (n_points, 3) [m]                       */
                            __global const float *normal,   /* (n_points, 3) unit                      */
                            __global float *direct,         /* (n_points, n_emitters) [1] or [m^-2]    */
                            const uint first_point, const uint n_samples, const uint n_pilot,
                            const uint n_emitters, const uint occlusion, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = first_point + i / n_emitters;
    const uint emitter = i % n_emitters;
    const float3 x = hr_load3(position, point);
    const float3 n = hr_load3(normal, point);
    const float factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    if (factor <= 0.0f || !occlusion) {
        direct[i] = factor;
        return;
    }
    const uint lamp_seed = hr_combine(hr_combine(seed, point), emitter);
    const uint rays = emitter_patch[emitter] == HR_NONE ? 1 : n_samples;
    float weight = 0.0f, open = 0.0f;
    for (uint k = 0; k < rays; ++k) {
        if (k == n_pilot && (open == 0.0f || open == weight))
            break;
        const float3 y = hr_emitter_point(emitter, hr_sample(k, 0, lamp_seed), hr_sample(k, 1, lamp_seed),
                                          HR_EMITTER, HR_PATCH);
        const float w = hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
        weight += w;
        if (w > 0.0f)
            open += w * hr_open(x, n, HR_NONE, y, emitter_patch[emitter], scale, HR_BVH);
    }
    direct[i] = weight > 0.0f ? factor * (open / weight) : 0.0f;
}
