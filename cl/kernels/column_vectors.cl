/* Steps of an iteration on (rows, columns) arrays, eight columns at a time; a work-item a row and group of columns. */
#include "include/hr_columns.h"
#include "include/hr_double.h"

/* scaled = root * x */
__kernel void scale_columns(__global const float *root, /* (n_rows, 8 n_groups) */
                            __global const float *x,    /* (n_rows, 8 n_groups) */
                            __global float *scaled,     /* (n_rows, 8 n_groups) */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)scaled)[i] = ((hr_groups_in)root)[i] * ((hr_groups_in)x)[i];
}

/* image = x - root * product, in place of the product */
__kernel void finish_image(__global const float *root, /* (n_rows, 8 n_groups)                    */
                           __global const float *x,    /* (n_rows, 8 n_groups)                    */
                           __global float *image,      /* (n_rows, 8 n_groups), the product at first */
                           const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)image)[i] = ((hr_groups_in)x)[i] - ((hr_groups_in)root)[i] * ((hr_groups_in)image)[i];
}

/* y = y + factor * x, a factor a column */
__kernel void add_columns(__global float *y,            /* (n_rows, 8 n_groups) */
                          __global const float *x,      /* (n_rows, 8 n_groups) */
                          __global const float *factor, /* (8 n_groups,)        */
                          const uint n_groups, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)y)[i] += ((hr_groups_in)factor)[i % n_groups] * ((hr_groups_in)x)[i];
}

/* direction = residual + factor * direction, a factor a column */
__kernel void turn_columns(__global float *direction,      /* (n_rows, 8 n_groups) */
                           __global const float *residual, /* (n_rows, 8 n_groups) */
                           __global const float *factor,   /* (8 n_groups,)        */
                           const uint n_groups, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)direction)[i] =
            ((hr_groups_in)residual)[i] + ((hr_groups_in)factor)[i % n_groups] * ((hr_groups_in)direction)[i];
}

/* Every so many rows of x. */
__kernel void pick_rows(__global const float *x, /* (n_rows, 8 n_groups)   */
                        __global float *picked,  /* (n_picked, 8 n_groups) */
                        const uint every, const uint n_groups, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)picked)[i] = ((hr_groups_in)x)[(size_t)(i / n_groups) * every * n_groups + i % n_groups];
}

/* Sums of x * y over the rows of a chunk, in double precision and in their order; a work-item a chunk and group. */
__kernel void multiply_chunks(__global const float *x,          /* (n_rows, 8 n_groups)   */
                              __global const float *y,          /* (n_rows, 8 n_groups)   */
                              __global const uint *order,       /* (n_rows,) rows, chunk after chunk */
                              __global const uint *chunk_start, /* (n_chunks + 1,)        */
                              __global double *sums,            /* (n_chunks, 8 n_groups) */
                              const uint n_groups, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint chunk = i / n_groups, group = i % n_groups;
    double4 low = (double4)(0.0), high = (double4)(0.0);
    for (uint k = chunk_start[chunk]; k < chunk_start[chunk + 1]; ++k) {
        const size_t at = (size_t)order[k] * n_groups + group;
        const float8 a = ((hr_groups_in)x)[at], b = ((hr_groups_in)y)[at];
        low += (double4)((double)a.s0 * b.s0, (double)a.s1 * b.s1, (double)a.s2 * b.s2, (double)a.s3 * b.s3);
        high += (double4)((double)a.s4 * b.s4, (double)a.s5 * b.s5, (double)a.s6 * b.s6, (double)a.s7 * b.s7);
    }
    __global double4 *packs = (__global double4 *)sums;
    packs[2 * (size_t)i] = low;
    packs[2 * (size_t)i + 1] = high;
}
