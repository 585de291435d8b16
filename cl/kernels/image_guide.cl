/* Where the light of row elements comes from. */
#include "include/hr_guide.h"
#include "include/hr_path_steps.h"

/* What one ray from each of some rows meets in each part of its hemisphere, from places spread over the row:
   HR_GUIDE_SIDE x HR_GUIDE_SIDE parts of the square that stands for it, by rows. */
__kernel void trace_row_guides(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS,
                               __global const uint *patch_solid, /* (n_patches,) not 0: matter behind it  */
                               __global const uint *rows,        /* (n_guides,)                           */
                               __global uint *met_row,           /* (n_guides, HR_GUIDE_SIDE^2) row, or outcome */
                               const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint part = i % (HR_GUIDE_SIDE * HR_GUIDE_SIDE);
    const uint row = rows[i / (HR_GUIDE_SIDE * HR_GUIDE_SIDE)];
    const uint row_seed = hr_combine(seed, row);
    const uint plain = hr_combine(row_seed, part);
    const hr_place place = hr_place_on_row(row, hr_plain(plain, 0), hr_plain(plain, 1), HR_ELEMENT, HR_PATCH);
    const float u = ((float)(part % HR_GUIDE_SIDE) + hr_plain(plain, 2)) / (float)HR_GUIDE_SIDE;
    const float v = ((float)(part / HR_GUIDE_SIDE) + hr_plain(plain, 3)) / (float)HR_GUIDE_SIDE;
    const float3 d = hr_cosine_direction(place.normal, u, v);
    const hr_hit hit = hr_closest_hit(HR_BVH, hr_offset_origin(place.position, place.normal, scale), d, INFINITY,
                                      place.patch);
    met_row[i] = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
}
