/* Where the light of readings comes from. */
#include "include/hr_guide.h"
#include "include/hr_path_steps.h"

/* What one ray from each point meets in each part of its hemisphere: (HR_GUIDE_SIDE)^2 parts of the square that stands
   for it, by rows. */
__kernel void trace_guide(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS,
                          __global const float *position,   /* (n_points, 3) [m]                            */
                          __global const float *normal,     /* (n_points, 3) unit                           */
                          __global const uint *patch_solid, /* (n_patches,) 1: matter behind it             */
                          __global uint *met_row,           /* (n_points, HR_GUIDE_SIDE^2) row, or outcome  */
                          const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = i / (HR_GUIDE_SIDE * HR_GUIDE_SIDE);
    const uint part = i % (HR_GUIDE_SIDE * HR_GUIDE_SIDE);
    const uint plain = hr_combine(seed, i);
    const float u = ((float)(part % HR_GUIDE_SIDE) + hr_plain(plain, 0)) / (float)HR_GUIDE_SIDE;
    const float v = ((float)(part / HR_GUIDE_SIDE) + hr_plain(plain, 1)) / (float)HR_GUIDE_SIDE;
    const float3 n = hr_load3(normal, point);
    const float3 d = hr_cosine_direction(n, u, v);
    const hr_hit hit =
        hr_closest_hit(HR_BVH, hr_offset_origin(hr_load3(position, point), n, scale), d, INFINITY, HR_NONE);
    met_row[i] = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
}
