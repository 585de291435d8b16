/* A kernel that proves a build and a launch: y = a x. */
#include "include/hr_types.h"

__kernel void scale_values(__global const float *x, /* (n_items,) */
                           __global float *y,       /* (n_items,) */
                           const float factor, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        y[i] = factor * x[i];
}
