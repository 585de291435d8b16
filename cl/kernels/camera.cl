/* What a camera sees: one ray through the middle of each cell of a width x height grid over the picture. */
#include "include/hr_bvh.h"
#include "include/hr_camera.h"

__kernel void primary_hits(HR_BVH_PARAMS,
                           __global const float *camera, /* (4, 3): position [m], local; forward, right, down      */
                           __global uint *hit_side,      /* (height, width) 2 patch + side, or HR_NONE             */
                           __global float *hit_uv,       /* (height, width, 2) [1]                                 */
                           __global float *hit_t,        /* (height, width) [m] along the axis of view             */
                           const uint width, const uint height, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const float x = ((float)(i % width) + 0.5f) / (float)width;
    const float y = ((float)(i / width) + 0.5f) / (float)height;
    const float3 direction = hr_view_direction(x, y, hr_load3(camera, 1), hr_load3(camera, 2), hr_load3(camera, 3));
    const hr_hit hit = hr_closest_hit(HR_BVH, hr_load3(camera, 0), direction, INFINITY, HR_NONE);
    hit_side[i] = hit.patch == HR_NONE ? HR_NONE : 2u * hit.patch + hit.side;
    hit_uv[2 * i] = hit.u;
    hit_uv[2 * i + 1] = hit.v;
    hit_t[i] = hit.t;
}
