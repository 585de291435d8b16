/* Two-step paths from readings: the first hit is lit explicitly, at the second the solution is looked up. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"

#define HR_CANDIDATES 4u

/* Factor of one drawn emitter at a surface point, over the probability that it is drawn, times visibility.
   The point on the emitter is resampled from four stratified candidates by their weight, so that the open share is
   that of the light which arrives and not of the area (resampled importance sampling, Talbot et al. 2005). */
inline float hr_one_emitter(const float3 x, const float3 n, const uint own, const uint emitter, const float probability,
                            const float3 numbers, const uint occlusion, const float scale, HR_EMITTER_PARAMS,
                            HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    if (own == emitter_patch[emitter])
        return 0.0f;
    const float factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    if (factor <= 0.0f)
        return 0.0f;
    if (!occlusion)
        return factor / probability;
    float3 y[HR_CANDIDATES];
    float sum[HR_CANDIDATES];
    float total = 0.0f;
    for (uint c = 0; c < HR_CANDIDATES; ++c) {
        const float s = 0.5f * (numbers.x + (float)(c & 1u));
        const float t = 0.5f * (numbers.y + (float)(c >> 1));
        y[c] = hr_emitter_point(emitter, s, t, HR_EMITTER, HR_PATCH);
        total += hr_emitter_weight(x, n, y[c], emitter, HR_EMITTER, HR_PATCH);
        sum[c] = total;
    }
    if (total <= 0.0f)
        return 0.0f;
    uint taken = 0;
    while (taken + 1 < HR_CANDIDATES && numbers.z * total >= sum[taken])
        ++taken;
    const float3 origin = hr_offset_origin(x, n, scale);
    const int blocked = hr_any_hit(HR_BVH, origin, y[taken] - origin, 1.0f, own, emitter_patch[emitter]);
    return blocked ? 0.0f : factor / probability;
}

/* First entry of the ascending row of n sums that is greater than x. */
inline uint hr_draw(__global const float *sums, const uint n, const float x)
{
    uint low = 0, high = n - 1;
    while (low < high) {
        const uint middle = (low + high) / 2;
        if (x < sums[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

__kernel void trace_paths(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                          __global const float *position,       /* (n_points, 3) [m]                          */
                          __global const float *normal,         /* (n_points, 3) unit                         */
                          __global const uint *patch_solid,     /* (n_patches,) 1: matter behind it           */
                          __global const uint *side_material,   /* (n_patches, 2)                             */
                          __global const float *emitter_choice, /* (n_rows, n_emitters) summed probabilities  */
                          __global uint *path_material,         /* (n_points, n_samples) at the first hit     */
                          __global uint *path_emitter,          /* (n_points, n_samples) drawn there          */
                          __global float *path_gain,            /* (n_points, n_samples) of that emitter      */
                          __global uint *path_row,              /* (n_points, n_samples) row, or an outcome   */
                          const uint first_point, const uint n_samples, const uint n_emitters,
                          const uint occlusion, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = first_point + i / n_samples;
    const uint k = i % n_samples;
    const uint point_seed = hr_combine(seed, point);
    const float3 n0 = hr_load3(normal, point);
    const float3 d0 = hr_cosine_direction(n0, hr_sample(k, 0, point_seed), hr_sample(k, 1, point_seed));
    const float3 origin = hr_offset_origin(hr_load3(position, point), n0, scale);
    const hr_hit first = hr_closest_hit(HR_BVH, origin, d0, INFINITY, HR_NONE);

    path_emitter[i] = 0;
    path_gain[i] = 0.0f;
    if (first.patch == HR_NONE) {
        path_material[i] = HR_NONE;
        path_row[i] = d0.z > 0.0f ? HR_SKY : HR_MISS;
        return;
    }
    const uint cell =
        hr_cell_at(first.patch, first.side, first.u, first.v, cell_divisions, side_first_cell, patch_kind);
    if (cell == HR_NONE) {
        path_material[i] = HR_NONE;
        path_row[i] = first.side == HR_BACK && patch_solid[first.patch] ? HR_COVERED : HR_UNLIT;
        return;
    }
    const uint row = cell_row[cell];
    const float3 y = hr_patch_point(first.patch, first.u, first.v, HR_PATCH);
    const float3 n1 = hr_side_normal(first.patch, first.side, patch_normal);
    path_material[i] = side_material[2 * first.patch + first.side];
    if (n_emitters > 0) {
        __global const float *sums = emitter_choice + (size_t)row * n_emitters;
        const uint emitter = hr_draw(sums, n_emitters, hr_sample(k, 6, point_seed));
        const float probability = sums[emitter] - (emitter > 0 ? sums[emitter - 1] : 0.0f);
        const float3 numbers =
            (float3)(hr_sample(k, 4, point_seed), hr_sample(k, 5, point_seed), hr_sample(k, 7, point_seed));
        path_emitter[i] = emitter;
        path_gain[i] = hr_one_emitter(y, n1, first.patch, emitter, probability, numbers, occlusion, scale, HR_EMITTER,
                                      HR_PATCH, HR_BVH);
    }
    const float3 d1 = hr_cosine_direction(n1, hr_sample(k, 2, point_seed), hr_sample(k, 3, point_seed));
    const hr_hit second = hr_closest_hit(HR_BVH, hr_offset_origin(y, n1, scale), d1, INFINITY, first.patch);
    if (second.patch == HR_NONE) {
        path_row[i] = d1.z > 0.0f ? HR_SKY : HR_MISS;
        return;
    }
    const uint second_cell =
        hr_cell_at(second.patch, second.side, second.u, second.v, cell_divisions, side_first_cell, patch_kind);
    path_row[i] = second_cell != HR_NONE                               ? cell_row[second_cell]
                  : second.side == HR_BACK && patch_solid[second.patch] ? HR_COVERED
                                                                        : HR_UNLIT;
}
