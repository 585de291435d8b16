/* Where the light of readings comes from. */
#include "include/hr_guide.h"
#include "include/hr_path_steps.h"

/* What one ray meets in each part of some blocks of the square that stands for a point's hemisphere: blocks are parts of
   a square cut into `side` x `side`, and are themselves cut into `across` x `across`, by rows. */
__kernel void trace_guide(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS,
                          __global const float *position,    /* (n_points, 3) [m]                               */
                          __global const float *normal,      /* (n_points, 3) unit                              */
                          __global const uint *patch_solid,  /* (n_patches,) 1: matter behind it                */
                          __global const uint *block_point,  /* (n_blocks,) point                               */
                          __global const uint *block_number, /* (n_blocks,) which of its side x side, by rows   */
                          __global uint *met_row,            /* (n_blocks, across^2) row, or outcome            */
                          const uint across, const uint side, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint block = i / (across * across);
    const uint part = i % (across * across);
    const uint point = block_point[block];
    const uint plain = hr_combine(seed, i);
    const float fine = (float)(across * side);
    const uint x = block_number[block] % side * across + part % across;
    const uint y = block_number[block] / side * across + part / across;
    const float u = ((float)x + hr_plain(plain, 0)) / fine;
    const float v = ((float)y + hr_plain(plain, 1)) / fine;
    const float3 n = hr_load3(normal, point);
    const float3 d = hr_cosine_direction(n, u, v);
    const hr_hit hit =
        hr_closest_hit(HR_BVH, hr_offset_origin(hr_load3(position, point), n, scale), d, INFINITY, HR_NONE);
    met_row[i] = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
}
