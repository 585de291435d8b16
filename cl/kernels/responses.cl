/* Direct light at readings that weigh directions by a response of their own. */
#include "include/hr_bvh.h"
#include "include/hr_emitters.h"
#include "include/hr_response.h"
#include "include/hr_sampling.h"

/* What the point y of an emitter counts, which would send `light` without obstacles and response. */
HR_FORCE_INLINE float hr_counted(const float3 x, const float3 n, const float3 y, const uint patch, const float light,
                                 __global const float *response, const uint point, const uint occlusion,
                                 const float scale, HR_BVH_PARAMS)
{
    if (light <= 0.0f)
        return 0.0f;
    const float3 d = y - x;
    const float counted = light * hr_response(response, point, d / sqrt(hr_dot(d, d)));
    const float3 origin = hr_offset_origin(x, n, scale);
    return counted > 0.0f && occlusion && hr_any_hit(HR_BVH, origin, y - origin, 1.0f, HR_NONE, patch) ? 0.0f : counted;
}

/* Irradiance for unit emission of each emitter, weighted by the response: the closed form times the weighted mean of
   response and visibility. Near an emitter, points on it and directions by the cosine law are combined as in
   `direct_points`, with HR_EACH as there. */
__kernel void direct_responses(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                               __global const float *position, /* (n_points, 3) [m]                      */
                               __global const float *normal,   /* (n_points, 3) unit                     */
                               __global const float *response, /* (n_points, HR_RESPONSE_ENTRIES)        */
                               __global const uint *samples,   /* (n_points, n_emitters), with HR_EACH   */
                               __global float *direct,         /* (n_points, n_emitters) [1] or [m^-2]   */
                               const uint n_samples, const uint n_emitters, const uint occlusion, const uint seed,
                               const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = i / n_emitters;
    const uint emitter = i % n_emitters;
    const uint patch = emitter_patch[emitter];
    const float3 x = hr_load3(position, point);
    const float3 n = hr_load3(normal, point);
    const float factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    direct[i] = 0.0f;
    if (factor <= 0.0f)
        return;
    const uint lamp_seed = hr_combine(hr_combine(seed, point), emitter);
    const int near = patch != HR_NONE && hr_far_area(x, emitter, HR_EMITTER) <= 0.0f;
    float whole = 0.0f, whole_rest = 0.0f, counted = 0.0f, counted_rest = 0.0f;
#if HR_EACH
    const uint most = samples[i];
#else
    const uint most = n_samples;
#endif
    for (uint k = 0; k < (patch == HR_NONE ? 1 : most); ++k) {
        const float3 y = hr_emitter_point(emitter, hr_sample(k, 0, lamp_seed), hr_sample(k, 1, lamp_seed), HR_EMITTER,
                                          HR_PATCH);
        const float light = near ? hr_balanced_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH)
                                 : hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
        hr_add(&whole, &whole_rest, light);
        hr_add(&counted, &counted_rest,
               hr_counted(x, n, y, patch, light, response, point, occlusion, scale, HR_BVH));
        if (!near)
            continue;
        const float3 d = hr_cosine_direction(n, hr_sample(k, 2, lamp_seed), hr_sample(k, 3, lamp_seed));
        const float t = hr_aimed_at(x, d, emitter, HR_EMITTER, HR_PATCH);
        if (t <= 0.0f)
            continue;
        const float met = hr_balanced_weight(x, n, x + t * d, emitter, HR_EMITTER, HR_PATCH);
        hr_add(&whole, &whole_rest, met);
        hr_add(&counted, &counted_rest,
               hr_counted(x, n, x + t * d, patch, met, response, point, occlusion, scale, HR_BVH));
    }
    direct[i] = whole > 0.0f ? factor * (counted / whole) : 0.0f;
}
