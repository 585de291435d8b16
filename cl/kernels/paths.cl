/* Paths from readings: the first hits are lit explicitly, at the last the solution is looked up. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"

#define HR_CANDIDATES 4u

/* A point on an emitter, and the irradiance that it stands for if it is visible, for unit emission. */
typedef struct {
    float3 point;
    float factor;
} hr_lamp_point;

/* Near an emitter: the point is resampled from four stratified candidates by their weight, so that it follows the
   light that arrives and not the area (resampled importance sampling, Talbot et al. 2005); the factor is the closed
   form. */
HR_FORCE_INLINE hr_lamp_point hr_near_lamp_point(const float3 x, const float3 n, const uint emitter, const float3 numbers,
                                        HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    hr_lamp_point lamp;
    lamp.factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    float total = 0.0f;
    float sum[HR_CANDIDATES];
    float3 y[HR_CANDIDATES];
    for (uint c = 0; c < HR_CANDIDATES; ++c) {
        const float s = 0.5f * (numbers.x + (float)(c & 1u));
        const float t = 0.5f * (numbers.y + (float)(c >> 1));
        y[c] = hr_emitter_point(emitter, s, t, HR_EMITTER, HR_PATCH);
        total += hr_emitter_weight(x, n, y[c], emitter, HR_EMITTER, HR_PATCH);
        sum[c] = total;
    }
    uint taken = 0;
    while (taken + 1 < HR_CANDIDATES && numbers.z * total >= sum[taken])
        ++taken;
    lamp.point = y[taken];
    lamp.factor = total > 0.0f ? lamp.factor : 0.0f;
    return lamp;
}

/* Factor of one drawn emitter at a surface point on patch `own`, over the probability that it is drawn, times
   visibility. */
HR_FORCE_INLINE float hr_one_emitter(const float3 x, const float3 n, const uint own, const uint emitter, const float probability,
                            const float3 numbers, const uint occlusion, const float scale, HR_EMITTER_PARAMS,
                            HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    if (own == emitter_patch[emitter])
        return 0.0f;
    const float far_area = hr_far_area(x, emitter, HR_EMITTER);
    hr_lamp_point lamp;
    if (far_area > 0.0f) {
        lamp.point = hr_emitter_point(emitter, numbers.x, numbers.y, HR_EMITTER, HR_PATCH);
        lamp.factor = far_area * hr_emitter_weight(x, n, lamp.point, emitter, HR_EMITTER, HR_PATCH);
    } else
        lamp = hr_near_lamp_point(x, n, emitter, numbers, HR_EMITTER, HR_PATCH);
    if (lamp.factor <= 0.0f)
        return 0.0f;
    const float3 origin = hr_offset_origin(x, n, scale);
    if (occlusion && hr_any_hit(HR_BVH, origin, lamp.point - origin, 1.0f, own, emitter_patch[emitter]))
        return 0.0f;
    return lamp.factor / probability;
}

/* First entry of the ascending row of n sums that is greater than x. */
HR_FORCE_INLINE uint hr_draw(__global const float *sums, const uint n, const float x)
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

/* Light at a surface point from one drawn emitter: which, and its factor over the probability. */
typedef struct {
    uint emitter;
    float gain;
} hr_explicit;

HR_FORCE_INLINE hr_explicit hr_light_hit(const float3 y, const float3 n, const uint patch, const uint row,
                                const float4 numbers, __global const float *emitter_choice, const uint n_emitters,
                                const uint occlusion, const float scale, HR_EMITTER_PARAMS, HR_PATCH_PARAMS,
                                HR_BVH_PARAMS)
{
    hr_explicit light = {0, 0.0f};
    if (n_emitters == 0)
        return light;
    __global const float *sums = emitter_choice + (size_t)row * n_emitters;
    light.emitter = hr_draw(sums, n_emitters, numbers.w);
    const float probability = sums[light.emitter] - (light.emitter > 0 ? sums[light.emitter - 1] : 0.0f);
    light.gain = hr_one_emitter(y, n, patch, light.emitter, probability, numbers.xyz, occlusion, scale, HR_EMITTER,
                                HR_PATCH, HR_BVH);
    return light;
}

/* What a ray ended on, as a row element or an outcome. */
HR_FORCE_INLINE uint hr_row_of_hit(const hr_hit hit, const float3 direction, __global const uint *patch_solid,
                          __global const uint *cell_divisions, __global const uint *side_first_cell,
                          __global const uint *cell_row, __global const uint *patch_kind)
{
    if (hit.patch == HR_NONE)
        return direction.z > 0.0f ? HR_SKY : HR_MISS;
    const uint cell = hr_cell_at(hit.patch, hit.side, hit.u, hit.v, cell_divisions, side_first_cell, patch_kind);
    if (cell != HR_NONE)
        return cell_row[cell];
    return hit.side == HR_BACK && patch_solid[hit.patch] ? HR_COVERED : HR_UNLIT;
}

/* A path: first hit lit explicitly; at the second the solution is looked up, unless that hit is nearer than
   `near_factor` sizes of its element, where one value for the whole element is too coarse (corners, contacts):
   then that hit is lit explicitly too, and the solution is looked up at the third. */
__kernel void trace_paths(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                          __global const float *position,       /* (n_points, 3) [m]                             */
                          __global const float *normal,         /* (n_points, 3) unit                            */
                          __global const uint *patch_solid,     /* (n_patches,) 1: matter behind it              */
                          __global const uint *side_material,   /* (n_patches, 2)                                */
                          __global const float *row_size,       /* (n_rows,) edge of each element [m]            */
                          __global const float *emitter_choice, /* (n_rows, n_emitters) summed probabilities     */
                          __global uint *path_material,         /* (n_points, n_samples, 2) at the lit hits, or NONE */
                          __global uint *path_emitter,          /* (n_points, n_samples, 2) drawn there          */
                          __global float *path_gain,            /* (n_points, n_samples, 2) of that emitter      */
                          __global uint *path_row,              /* (n_points, n_samples) row, or an outcome      */
                          const uint n_samples, const uint n_emitters, const uint occlusion, const float near_factor,
                          const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = i / n_samples;
    const uint k = i % n_samples;
    const uint point_seed = hr_combine(seed, point);
    float3 n = hr_load3(normal, point);
    float3 d = hr_cosine_direction(n, hr_sample(k, 0, point_seed), hr_sample(k, 1, point_seed));
    hr_hit hit = hr_closest_hit(HR_BVH, hr_offset_origin(hr_load3(position, point), n, scale), d, INFINITY, HR_NONE);
    uint row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
    path_material[2 * i] = HR_NONE;
    path_material[2 * i + 1] = HR_NONE;

    float4 numbers = (float4)(hr_sample(k, 4, point_seed), hr_sample(k, 5, point_seed), hr_sample(k, 7, point_seed),
                              hr_sample(k, 6, point_seed));
    float2 next = (float2)(hr_sample(k, 2, point_seed), hr_sample(k, 3, point_seed));
    for (uint bounce = 0; bounce < 2 && HR_IS_ROW(row); ++bounce) {
        if (bounce == 1 && hit.t >= near_factor * row_size[row])
            break;
        const float3 y = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
        n = hr_side_normal(hit.patch, hit.side, patch_normal);
        const hr_explicit light = hr_light_hit(y, n, hit.patch, row, numbers, emitter_choice, n_emitters, occlusion,
                                               scale, HR_EMITTER, HR_PATCH, HR_BVH);
        path_material[2 * i + bounce] = side_material[2 * hit.patch + hit.side];
        path_emitter[2 * i + bounce] = light.emitter;
        path_gain[2 * i + bounce] = light.gain;
        d = hr_cosine_direction(n, next.x, next.y);
        hit = hr_closest_hit(HR_BVH, hr_offset_origin(y, n, scale), d, INFINITY, hit.patch);
        row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
        /* Few paths come here again: plain random numbers serve them. */
        const uint second_seed = hr_combine(point_seed, k + 0x51ed270bu);
        numbers = (float4)(hr_unit_float(hr_combine(second_seed, 0)), hr_unit_float(hr_combine(second_seed, 1)),
                           hr_unit_float(hr_combine(second_seed, 2)), hr_unit_float(hr_combine(second_seed, 3)));
        next = (float2)(hr_unit_float(hr_combine(second_seed, 4)), hr_unit_float(hr_combine(second_seed, 5)));
    }
    path_row[i] = row;
}
