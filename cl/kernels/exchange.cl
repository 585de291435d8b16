/* Rays from row elements: the samples of the exchange between elements. */
#include "include/hr_covered.h"
#include "include/hr_elements.h"
#include "include/hr_outcomes.h"

/* Ray `k` of row `r` starts at the k-th point of the row's own sequence, with density cos/pi about the normal. */
__kernel void trace_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_SOLID_PARAMS,
                         __global uint *hit_row,  /* (n_rows, n_samples) row, or an outcome */
                         __global uint *hit_side, /* (n_rows, n_samples) 2 patch + side     */
                         const uint first_row, const uint n_samples, const uint seed, const float scale,
                         const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = first_row + i / n_samples;
    const uint k = i % n_samples;
    const uint row_seed = hr_combine(seed, row);
    const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed), HR_ELEMENT,
                                           HR_PATCH);
    const float3 direction =
        hr_cosine_direction(place.normal, hr_sample(k, 2, row_seed), hr_sample(k, 3, row_seed));
    const float3 origin = hr_offset_origin(place.position, place.normal, scale);
    const hr_hit hit = hr_closest_hit(HR_BVH, origin, direction, INFINITY, place.patch);
    uint outcome;
    if (hit.patch == HR_NONE)
        outcome = direction.z > 0.0f ? HR_SKY : HR_MISS;
    else if (hr_leaves_solid(hit, origin, direction, scale, patch_normal, HR_SOLID, HR_BVH))
        outcome = HR_COVERED;
    else {
        const uint cell =
            hr_cell_at(hit.patch, hit.side, hit.u, hit.v, cell_divisions, side_first_cell, patch_kind);
        outcome = cell == HR_NONE ? HR_UNLIT : cell_row[cell];
    }
    hit_row[i] = outcome;
    hit_side[i] = hit.patch == HR_NONE ? HR_NONE : 2 * hit.patch + hit.side;
}
