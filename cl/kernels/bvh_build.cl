/* One level of the ray structure: each work-item makes one 8-wide node out of its range of boxes. */
#include "include/hr_bvh_build.h"

__kernel void split_nodes(__global float *boxes,            /* (n_boxes, 8) [m], reordered inside each range      */
                          __global uint *names,             /* (n_boxes,) reordered alike                         */
                          __global const uint *node_range,  /* (n_items, 2) begin, end                            */
                          __global float *child_bounds,     /* (n_items, 8, 8) [m]                                */
                          __global uint *child_range,       /* (n_items, 8, 2) begin, end; equal: no such child   */
                          const uint halve,                 /* 1: by number of boxes instead of surface area      */
                          const uint n_items)
{
    const uint node = get_global_id(0);
    if (node >= n_items)
        return;
    float8 bounds[8];
    uint begin[8];
    uint end[8];
    const uint n = hr_split_node((__global float8 *)boxes, names, node_range[2 * node], node_range[2 * node + 1], halve,
                                 bounds, begin, end);
    for (uint child = 0; child < 8u; child++) {
        const uint row = 8u * node + child;
        vstore8(child < n ? bounds[child] : hr_no_bounds(), row, child_bounds);
        child_range[2 * row] = child < n ? begin[child] : 0u;
        child_range[2 * row + 1] = child < n ? end[child] : 0u;
    }
}
