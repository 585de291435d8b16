/* Direct light: closed-form factor times sampled visibility. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"
#include "include/hr_shaft.h"
#include "include/hr_sight.h"

/* Rays that take about as long as a proof that they are free. */
#define HR_RAYS_OF_A_SHAFT 16u

/* Is the way from x (unit normal n, on patch `own`) to the point y of the emitter free? */
HR_FORCE_INLINE float hr_open(const float3 x, const float3 n, const uint own, const float3 y, const uint emitter_patch,
                     const float scale, HR_BVH_PARAMS)
{
    const float3 origin = hr_offset_origin(x, n, scale);
    return hr_any_hit(HR_BVH, origin, y - origin, 1.0f, own, emitter_patch) ? 0.0f : 1.0f;
}

/* Part of a near area emitter's factor that is hidden from x, estimated by one point drawn on the emitter and one
   direction drawn by the cosine law; without bias, and 0 where nothing stands in the way. `clear` gets the same with
   everything taken for hidden: as much as the two samples could find. */
HR_FORCE_INLINE float hr_hidden(const float3 x, const float3 n, const uint own, const uint emitter, const float4 numbers,
                                float *clear, const float scale, HR_EMITTER_PARAMS, HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    const float3 y = hr_emitter_point(emitter, numbers.x, numbers.y, HR_EMITTER, HR_PATCH);
    const float drawn = hr_balanced_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
    float hidden = 0.0f;
    if (drawn > 0.0f)
        hidden += drawn * (1.0f - hr_open(x, n, own, y, emitter_patch[emitter], scale, HR_BVH));
    const float3 d = hr_cosine_direction(n, numbers.z, numbers.w);
    const float t = hr_aimed_at(x, d, emitter, HR_EMITTER, HR_PATCH);
    float met = 0.0f;
    if (t > 0.0f) {
        met = hr_balanced_weight(x, n, x + t * d, emitter, HR_EMITTER, HR_PATCH);
        hidden += met * (1.0f - hr_open(x, n, own, x + t * d, emitter_patch[emitter], scale, HR_BVH));
    }
    *clear = drawn + met;
    return hidden;
}

/* What each emitter would send to each row without any obstacle, for unit emission: mean over points spread over it.
   With HR_ROUGH by the emitter's middle alone where it is far away, which takes half of the time. */
__kernel void bound_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                         __global const uchar *row_sight, /* (n_rows, n_emitters) HR_SIGHT_…     */
                         __global float *clear,           /* (n_rows, n_emitters) [1] or [m^-2]  */
                         const uint n_points, const uint n_emitters, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    if (row_sight[i] == HR_SIGHT_HIDDEN) {
        clear[i] = 0.0f;
        return;
    }
    const uint row = i / n_emitters, emitter = i % n_emitters;
    float sum = 0.0f;
    for (uint k = 0; k < n_points; ++k) {
        const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row), hr_sample(k, 1, row), HR_ELEMENT, HR_PATCH);
        if (place.patch == emitter_patch[emitter])
            continue;
        const float3 x = place.position, n = place.normal;
#if HR_ROUGH
        const float far_area = emitter_patch[emitter] == HR_NONE ? 1.0f : hr_far_area(x, emitter, HR_EMITTER);
        if (far_area > 0.0f) {
            const float3 middle = hr_emitter_point(emitter, 0.5f, 0.5f, HR_EMITTER, HR_PATCH);
            sum += far_area * hr_emitter_weight(x, n, middle, emitter, HR_EMITTER, HR_PATCH);
            continue;
        }
#endif
        sum += hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    }
    clear[i] = sum / (float)n_points;
}

/* Irradiance of each row's exposed part for unit emission of each emitter. The points are the origins of the row's own
   exchange rays, so that both see the same part of the element. Where nothing stands between, each point takes the
   closed form. Else, from afar each takes one sample of the kernel; near an emitter it takes the closed form less what
   is found hidden if another point found the emitter open, and what it finds open itself if none did: no noise in full
   view, 0 behind a wall, and no bias, since rays near an emitter are drawn independently of those of other points.
   With HR_CHANCE an emitter is tried with a probability of its own, and what it sends counts as many times more; with
   HR_EACH each row has a number of points of its own for every emitter, more than rays only where none of these is
   covered. */
__kernel void direct_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                          __global const uint *hit_row, /* (n_rows, n_samples), from trace_rows          */
                          __global const uchar *row_sight, /* (n_rows, n_emitters) HR_SIGHT_…            */
                          __global const float *chance, /* (n_rows, n_emitters) of trying, with HR_CHANCE */
                          __global const uint *row_points, /* (n_rows, n_emitters), with HR_EACH         */
                          __global float *direct,       /* (n_rows, n_emitters) [1] or [m^-2]            */
                          const uint n_samples, const uint n_points, const uint n_emitters, const uint occlusion,
                          const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    if (row_sight[i] == HR_SIGHT_HIDDEN) {
        direct[i] = 0.0f;
        return;
    }
    const int is_free = !occlusion || row_sight[i] == HR_SIGHT_FREE;
    const uint row = i / n_emitters;
    const uint emitter = i % n_emitters;
    const uint patch = emitter_patch[emitter];
    const uint row_seed = hr_combine(seed, row);
    const uint lamp_seed = hr_combine(row_seed, emitter);
    float counts = 1.0f;
#if HR_CHANCE
    if (hr_unit_float(hr_hash(lamp_seed + 0x2545f491u)) >= chance[i]) {
        direct[i] = 0.0f;
        return;
    }
    counts = 1.0f / chance[i];
#endif
#if HR_EACH
    const uint most = row_points[i];
#else
    const uint most = n_points;
#endif
    float sum = 0.0f;
    float lone = 0.0f;
    uint exposed = 0, open = 0;
    for (uint k = 0; (k < n_samples || exposed == k) && exposed < most; ++k) {
        if (k < n_samples && hit_row[row * n_samples + k] == HR_COVERED)
            continue;
        ++exposed;
        const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed),
                                               HR_ELEMENT, HR_PATCH);
        if (place.patch == patch)
            continue;
        const float3 x = place.position, n = place.normal;
        if (is_free) {
            sum += hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
            ++open;
            continue;
        }
        const float2 at = (float2)(hr_sample(k, 2, lamp_seed), hr_sample(k, 3, lamp_seed));
        const float far_area = patch == HR_NONE ? 1.0f : hr_far_area(x, emitter, HR_EMITTER);
        if (far_area > 0.0f) {
            const float3 y = hr_emitter_point(emitter, at.x, at.y, HR_EMITTER, HR_PATCH);
            const float light = far_area * hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
            if (light > 0.0f && hr_open(x, n, place.patch, y, patch, scale, HR_BVH) > 0.0f) {
                sum += light;
                lone = 0.0f;
                ++open;
            }
            continue;
        }
        const float factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
        if (factor <= 0.0f)
            continue;
        float clear;
        const uint own_seed = hr_combine(lamp_seed, k);
        const float hidden = hr_hidden(x, n, place.patch, emitter,
                                       (float4)(hr_sample(0, 2, own_seed), hr_sample(0, 3, own_seed),
                                                hr_sample(0, 4, own_seed), hr_sample(0, 5, own_seed)),
                                       &clear, scale, HR_EMITTER, HR_PATCH, HR_BVH);
        if (hidden < clear) {
            lone = factor - clear;
            ++open;
        }
        sum += factor - hidden;
    }
    direct[i] = counts * (open > 1 ? sum / (float)exposed : open > 0 ? (sum - lone) / (float)exposed : 0.0f);
}

/* Whether a shaft proves that nothing stands between the point x and an area emitter. */
HR_FORCE_INLINE int hr_proved_free(const float3 x, const float3 n, const uint emitter, const uint most_visits,
                                   const float scale, HR_EMITTER_PARAMS, HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    const float3 origin = hr_load3(patch_origin, patch);
    const float3 eu = hr_load3(patch_edge_u, patch);
    const float3 ev = hr_load3(patch_edge_v, patch);
    const float3 point[4] = {x, x, x, x};
    const float3 corner[4] = {origin, origin + eu, patch_kind[patch] ? origin + ev : origin + eu + ev, origin + ev};
    return hr_sight(HR_BVH, point, n, HR_NONE, corner, hr_load3(patch_normal, patch), patch, emitter_two_sided[emitter],
                    scale, INFINITY, most_visits) == HR_SIGHT_FREE;
}

/* One ray to an emitter with the probability `chance`, counting as many times more. An emitter taken for `seen` has its
   closed form less what is found hidden, any other what is found open: neither has a bias, whatever it is taken for, and
   no noise where that is right. */
HR_FORCE_INLINE float hr_direct_by_chance(const float3 x, const float3 n, const uint emitter, const float chance,
                                          const int seen, const uint lamp_seed, const float scale, HR_EMITTER_PARAMS,
                                          HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    const float whole = seen ? hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH) : 0.0f;
    if (hr_unit_float(hr_hash(lamp_seed + 0x2545f491u)) >= chance || (seen && whole <= 0.0f))
        return whole;
    const uint patch = emitter_patch[emitter];
    const float2 at = (float2)(hr_sample(0, 0, lamp_seed), hr_sample(0, 1, lamp_seed));
    const float far_area = patch == HR_NONE ? 1.0f : hr_far_area(x, emitter, HR_EMITTER);
    float hidden = 0.0f, clear = 0.0f;
    if (far_area > 0.0f) {
        const float3 y = hr_emitter_point(emitter, at.x, at.y, HR_EMITTER, HR_PATCH);
        clear = far_area * hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
        hidden = clear > 0.0f ? clear * (1.0f - hr_open(x, n, HR_NONE, y, patch, scale, HR_BVH)) : 0.0f;
    } else if (seen || hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH) > 0.0f)
        hidden = hr_hidden(x, n, HR_NONE, emitter,
                           (float4)(at.x, at.y, hr_sample(0, 2, lamp_seed), hr_sample(0, 3, lamp_seed)), &clear, scale,
                           HR_EMITTER, HR_PATCH, HR_BVH);
    return whole + (seen ? -hidden : clear - hidden) / chance;
}

/* The same at single points, as the closed form times the open share of the weighted rays; of many rays only where no
   shaft with most_visits nodes and leaves proves that they are free (0: no proof is tried).
   With n_pilot < n_samples, for pictures: after so many rays that all agree the emitter counts as wholly open or
   hidden, and all points send their rays to the same places, so that soft edges have no grain.
   With HR_EACH every point has a number of rays of its own for every emitter; below two see hr_direct_by_chance. */
__kernel void direct_points(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                            __global const float *position, /* (n_points, 3) [m]                       */
                            __global const float *normal,   /* (n_points, 3) unit                      */
                            __global const float *samples,  /* (n_points, n_emitters), with HR_EACH    */
                            __global const uchar *seen,     /* (n_points, n_emitters) 1: taken for seen, with HR_EACH */
                            __global float *direct,         /* (n_points, n_emitters) [1] or [m^-2]    */
                            const uint first_point, const uint n_samples, const uint n_pilot,
                            const uint n_emitters, const uint occlusion, const uint most_visits, const uint seed,
                            const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = first_point + i / n_emitters;
    const uint emitter = i % n_emitters;
    const float3 x = hr_load3(position, point);
    const float3 n = hr_load3(normal, point);
    const uint lamp_seed = hr_combine(n_pilot < n_samples ? seed : hr_combine(seed, point), emitter);
#if HR_EACH
    if (occlusion && samples[i] < 2.0f) {
        direct[i] = hr_direct_by_chance(x, n, emitter, hr_smaller(samples[i], 1.0f), seen[i], lamp_seed, scale,
                                        HR_EMITTER, HR_PATCH, HR_BVH);
        return;
    }
#endif
    const float factor = hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH);
    if (factor <= 0.0f || !occlusion) {
        direct[i] = factor;
        return;
    }
    const int near = emitter_patch[emitter] != HR_NONE && hr_far_area(x, emitter, HR_EMITTER) <= 0.0f;
#if HR_EACH
    const uint most = (uint)samples[i];
#else
    const uint most = n_samples;
#endif
    const uint rays = emitter_patch[emitter] == HR_NONE ? 1 : most;
    if (most_visits && min(rays, n_pilot) >= HR_RAYS_OF_A_SHAFT &&
        hr_proved_free(x, n, emitter, most_visits, scale, HR_EMITTER, HR_PATCH, HR_BVH)) {
        direct[i] = factor;
        return;
    }
    float weight = 0.0f, weight_rest = 0.0f, open = 0.0f, open_rest = 0.0f;
    for (uint k = 0; k < rays; ++k) {
        if (k == n_pilot && (open == 0.0f || open == weight))
            break;
        const float2 at = (float2)(hr_sample(k, 0, lamp_seed), hr_sample(k, 1, lamp_seed));
        if (near) {
            float clear;
            const float hidden =
                hr_hidden(x, n, HR_NONE, emitter,
                          (float4)(at.x, at.y, hr_sample(k, 2, lamp_seed), hr_sample(k, 3, lamp_seed)), &clear, scale,
                          HR_EMITTER, HR_PATCH, HR_BVH);
            hr_add(&weight, &weight_rest, clear);
            hr_add(&open, &open_rest, clear - hidden);
            continue;
        }
        const float3 y = hr_emitter_point(emitter, at.x, at.y, HR_EMITTER, HR_PATCH);
        const float w = hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
        hr_add(&weight, &weight_rest, w);
        if (w > 0.0f)
            hr_add(&open, &open_rest, w * hr_open(x, n, HR_NONE, y, emitter_patch[emitter], scale, HR_BVH));
    }
    direct[i] = weight > 0.0f ? factor * (open / weight) : 0.0f;
}

/* Summed probabilities with which lamps are drawn at hits on each row: `found_share` of them by the light that was found
   there, `clear_share` by the light without obstacles, the rest evenly. Where lamps are many, few are tried in a
   replicate, and what one that was not tried sends would count as often as an even share is small. */
__kernel void choose_lamps(__global const float *direct,     /* (n_rows, n_emitters) of this replicate   */
                           __global const float *clear,      /* (n_rows, n_emitters) without obstacles   */
                           __global const float *brightness, /* (n_emitters,) of a unit of each          */
                           __global float *sums,             /* (n_rows, n_emitters) ascending, last 1   */
                           const float found_share, const float clear_share, const uint n_emitters,
                           const uint n_items)
{
    const uint row = get_global_id(0);
    if (row >= n_items)
        return;
    const size_t first = (size_t)row * n_emitters;
    float found = 0.0f, without = 0.0f;
    for (uint e = 0; e < n_emitters; ++e) {
        found += hr_larger(direct[first + e], 0.0f) * brightness[e];
        without += clear[first + e] * brightness[e];
    }
    const float by_found = found > 0.0f ? found_share / found : 0.0f;
    const float by_clear = without > 0.0f ? clear_share / without : 0.0f;
    const float even = (1.0f - (found > 0.0f ? found_share : 0.0f) - (without > 0.0f ? clear_share : 0.0f)) /
                       (float)n_emitters;
    float sum = 0.0f;
    for (uint e = 0; e < n_emitters; ++e) {
        sum += (by_found * hr_larger(direct[first + e], 0.0f) + by_clear * clear[first + e]) * brightness[e] + even;
        sums[first + e] = sum;
    }
    sums[first + n_emitters - 1] = 1.0f;
}
