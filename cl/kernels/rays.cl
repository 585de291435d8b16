/* Arrays of rays against the patches, one ray a work-item. */
#include "include/hr_bvh.h"

__kernel void trace_closest(HR_BVH_PARAMS,
                            __global const float *origin,    /* (n_items, 3) [m], local                            */
                            __global const float *direction, /* (n_items, 3)                                       */
                            __global const float *t_max,     /* (n_items,) [lengths of direction]                  */
                            __global const uint *skip_patch, /* (n_items,) or HR_NONE                              */
                            __global uint *hit_patch,        /* (n_items,) or HR_NONE                              */
                            __global uchar *hit_side,        /* (n_items,) 0 front, 1 back                         */
                            __global float *hit_t,           /* (n_items,) [lengths of direction]                  */
                            __global float *hit_uv,          /* (n_items, 2) [1]                                   */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const hr_hit hit = hr_closest_hit(HR_BVH, hr_load3(origin, i), hr_load3(direction, i), t_max[i], skip_patch[i]);
    hit_patch[i] = hit.patch;
    hit_side[i] = (uchar)hit.side;
    hit_t[i] = hit.t;
    hit_uv[2 * i] = hit.u;
    hit_uv[2 * i + 1] = hit.v;
}

__kernel void trace_any(HR_BVH_PARAMS,
                        __global const float *origin,    /* (n_items, 3) [m], local             */
                        __global const float *direction, /* (n_items, 3)                        */
                        __global const float *t_max,     /* (n_items,) [lengths of direction]   */
                        __global const uint *skip_patch, /* (n_items,) or HR_NONE               */
                        __global const uint *skip_other, /* (n_items,) or HR_NONE               */
                        __global uchar *is_hit,          /* (n_items,) 0 or 1                   */
                        const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        is_hit[i] = (uchar)hr_any_hit(HR_BVH, hr_load3(origin, i), hr_load3(direction, i), t_max[i], skip_patch[i],
                                      skip_other[i]);
}
