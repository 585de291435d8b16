/* Paths from readings: the first hits are lit explicitly, at the last the solution is looked up. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_emitters.h"
#include "include/hr_guide.h"
#include "include/hr_path_steps.h"
#include "include/hr_response.h"
#include "include/hr_sight.h"

/* Light at a surface point from one drawn emitter: which, its factor over the probability with which it was drawn, and,
   if it is near, that probability, else 0: the next direction then has its say as well (see hr_found_on_ray). */
typedef struct {
    uint emitter;
    float gain;
    float near_probability;
    int clear; /* of a near emitter: the gain is the closed form less what is found hidden */
} hr_explicit;

/* A near emitter is sampled by one point on it and by the path's next direction, combined by the balance heuristic:
   what they find open is added up where the element sees less than half of the emitter, and what they find hidden is
   taken off the closed form where it sees more. Neither has a bias, behind a wall the first is exactly 0, and in full
   view the second has no noise. */
HR_FORCE_INLINE hr_explicit hr_light_hit(const float3 x, const float3 n, const uint own, const uint row,
                                         const float3 numbers, __global const float *emitter_choice,
                                         __global const float *row_direct, __global const uchar *row_sight,
                                         const uint n_emitters, const uint occlusion, const float scale,
                                         HR_EMITTER_PARAMS, HR_PATCH_PARAMS, HR_BVH_PARAMS)
{
    hr_explicit light = {0, 0.0f, 0.0f, 0};
    if (n_emitters == 0)
        return light;
    const int known = HR_IS_ROW(row);
    __global const float *sums = emitter_choice + (known ? (size_t)row * n_emitters : 0);
    const uint emitter = known ? hr_draw(sums, n_emitters, numbers.z)
                               : (uint)hr_smaller(numbers.z * (float)n_emitters, (float)(n_emitters - 1));
    const uint patch = emitter_patch[emitter];
    const float probability =
        known ? sums[emitter] - (emitter > 0 ? sums[emitter - 1] : 0.0f) : 1.0f / (float)n_emitters;
    light.emitter = emitter;
    if (own == patch)
        return light;
    const float far_area = patch == HR_NONE ? 1.0f : hr_far_area(x, emitter, HR_EMITTER);
    const int near = far_area <= 0.0f;
    const float3 y = hr_emitter_point(emitter, numbers.x, numbers.y, HR_EMITTER, HR_PATCH);
    const float factor = near ? hr_emitter_factor(x, n, emitter, HR_EMITTER, HR_PATCH)
                              : far_area * hr_emitter_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH);
    if (factor <= 0.0f)
        return light;
    if (!occlusion || (known && row_sight[(size_t)row * n_emitters + emitter] == HR_SIGHT_FREE)) {
        light.gain = factor / probability;
        return light;
    }
    light.near_probability = near ? probability : 0.0f;
    light.clear = near && known && row_direct[(size_t)row * n_emitters + emitter] > 0.5f * factor;
    const float drawn = near ? hr_balanced_weight(x, n, y, emitter, HR_EMITTER, HR_PATCH) : factor;
    const float3 origin = hr_offset_origin(x, n, scale);
    const int hidden = drawn > 0.0f && hr_any_hit(HR_BVH, origin, y - origin, 1.0f, own, patch);
    light.gain = (light.clear ? factor - (hidden ? drawn : 0.0f) : hidden ? 0.0f : drawn) / probability;
    return light;
}

/* Paths of `path_number`: hits are lit explicitly until the solution is looked up, at the hit number `lookup` at the
   earliest, and never at a hit nearer than `near_factor` sizes of its element, or `first_near_factor` at the first hit:
   there one value for the whole element is too coarse (corners, contacts, slots). Sides that no light was found to
   reach have no solution: there the path goes on. A path that has no place left for a further lit hit is left out and
   marked HR_LONG, to be traced again with more places, or looks the solution up all the same if `last_chance` is set.
   With HR_GUIDED the first directions follow the light that was found before (2: some parts are cut finer), and paths
   weigh accordingly; with HR_RESPONSE they also weigh as the readings' responses say. */
__kernel void trace_paths(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_EMITTER_PARAMS,
                          __global const float *position,       /* (n_points, 3) [m]                             */
                          __global const float *normal,         /* (n_points, 3) unit                            */
                          __global const uint *patch_solid,     /* (n_patches,) 1: matter behind it              */
                          __global const uint *side_paint,      /* (n_patches, 2)                                */
                          __global const float *row_size,       /* (n_rows,) edge of each element [m]; INFINITY: no lookup;
                                                                   below 0: near_factor holds at first hits too  */
                          __global const float *emitter_choice, /* (n_rows, n_emitters) summed probabilities     */
                          __global const float *row_direct,     /* (n_rows, n_emitters) of each element          */
                          __global const uchar *row_sight,      /* (n_rows, n_emitters) HR_SIGHT_…               */
                          __global const float *guide,          /* (n_points, HR_GUIDE_ENTRIES), with HR_GUIDED  */
                          __global const uint *guide_first,     /* (n_points + 1,) into the blocks of the guide  */
                          __global const uint *guide_key,       /* (n_blocks,) see hr_fine_guide, with HR_GUIDED 2 */
                          __global const float *guide_block,    /* (n_blocks, HR_GUIDE_BLOCK_ENTRIES)            */
                          __global const float *response,       /* (n_points, HR_RESPONSE_ENTRIES), with HR_RESPONSE */
                          __global const uint *path_number,     /* (n_paths,) n_samples point + sample           */
                          __global uint *path_paint,            /* (n_paths, HR_LIT_HITS) at the lit hits, or NONE */
                          __global uint *path_emitter,          /* (n_paths, HR_LIT_HITS) drawn there            */
                          __global float *path_gain,            /* (n_paths, HR_LIT_HITS) of that emitter        */
                          __global uint *path_row,              /* (n_paths,) row, or an outcome                 */
                          __global float *path_weight,          /* (n_paths,) 1 over the density of its start    */
                          const uint n_samples, const uint n_emitters, const uint occlusion, const uint lookup,
                          const float near_factor, const float first_near_factor, const uint last_chance,
                          const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = path_number[i] / n_samples;
    const uint k = path_number[i] % n_samples;
    const uint point_seed = hr_combine(seed, point);
    const size_t first = (size_t)i * HR_LIT_HITS;
    float3 n = hr_load3(normal, point);
    float3 start = (float3)(hr_sample(k, 0, point_seed), hr_sample(k, 1, point_seed), 1.0f);
#if HR_GUIDED == 1
    start = hr_guide(guide + (size_t)point * HR_GUIDE_ENTRIES, start.x, start.y);
#elif HR_GUIDED == 2
    const uint block = guide_first[point];
    start = hr_fine_guide(guide + (size_t)point * HR_GUIDE_ENTRIES, guide_key + block, guide_first[point + 1] - block,
                          guide_block + (size_t)block * HR_GUIDE_BLOCK_ENTRIES, start.x, start.y);
#endif
    path_weight[i] = start.z;
    float3 d = hr_cosine_direction(n, start.x, start.y);
#if HR_RESPONSE
    path_weight[i] *= hr_response(response, point, d);
#endif
    hr_hit hit = hr_closest_hit(HR_BVH, hr_offset_origin(hr_load3(position, point), n, scale), d, INFINITY, HR_NONE);
    uint row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);

    float3 numbers = (float3)(hr_sample(k, 4, point_seed), hr_sample(k, 5, point_seed), hr_sample(k, 6, point_seed));
    float2 next = (float2)(hr_sample(k, 2, point_seed), hr_sample(k, 3, point_seed));
    const uint plain = hr_combine(point_seed, k + 0x51ed270bu);
    uint lit = 0;
    for (; HR_IS_ROW(row) || row == HR_UNLIT; ++lit) {
        if (HR_IS_ROW(row)) {
            const float size = row_size[row];
            const float sizes_away = lit == 0 && size >= 0.0f ? first_near_factor : near_factor;
            if (lit + 1 >= lookup && hit.t >= sizes_away * hr_magnitude(size))
                break;
        }
        if (lit == HR_LIT_HITS) {
            row = last_chance ? row : HR_LONG;
            break;
        }
        const float3 y = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
        n = hr_side_normal(hit.patch, hit.side, patch_normal);
        hr_explicit light = hr_light_hit(y, n, hit.patch, row, numbers, emitter_choice, row_direct, row_sight,
                                         n_emitters, occlusion, scale, HR_EMITTER, HR_PATCH, HR_BVH);
        path_paint[first + lit] = side_paint[2 * hit.patch + hit.side];
        path_emitter[first + lit] = light.emitter;
        d = hr_cosine_direction(n, next.x, next.y);
        hit = hr_closest_hit(HR_BVH, hr_offset_origin(y, n, scale), d, INFINITY, hit.patch);
        if (light.near_probability > 0.0f)
            light.gain += hr_found_on_ray(y, n, d, hit.patch, hit.t, light.emitter, light.clear, HR_EMITTER, HR_PATCH) /
                          light.near_probability;
        path_gain[first + lit] = light.gain;
        row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
        /* Fewer and weaker paths come here a second time: plain random numbers serve them. */
        numbers = (float3)(hr_plain(plain, 5 * lit), hr_plain(plain, 5 * lit + 1), hr_plain(plain, 5 * lit + 2));
        next = (float2)(hr_plain(plain, 5 * lit + 3), hr_plain(plain, 5 * lit + 4));
    }
    if (row == HR_LONG)
        lit = 0;
    for (; lit < HR_LIT_HITS; ++lit)
        path_paint[first + lit] = HR_NONE;
    path_row[i] = row;
}
