/* Products with spectra: band-free transport times (rows, columns) arrays, eight columns at a time. */
#include "include/hr_columns.h"
#include "include/hr_types.h"

/* product[r] = sum over the links of row r of value * columns[source]; one work-item a row and group of 8 columns. */
__kernel void apply_links(__global const uint *link_start,  /* (n_rows + 1,)                   */
                          __global const uint *link_source, /* (n_links,)                      */
                          __global const float *link_value, /* (n_links,)                      */
                          __global const float *columns,    /* (n_rows, 8 n_groups)            */
                          __global float *product,          /* (n_rows, 8 n_groups)            */
                          const uint n_items)
{
    const uint row = get_global_id(0);
    if (row >= n_items)
        return;
    float8 sum[HR_GROUPS];
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] = (float8)(0.0f);
    const uint end = link_start[row + 1];
    for (uint l = link_start[row]; l < end; ++l) {
        const float value = link_value[l];
        hr_groups_in source = (hr_groups_in)columns + (size_t)link_source[l] * HR_GROUPS;
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            sum[g] += value * source[g];
    }
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)product)[(size_t)row * HR_GROUPS + g] = sum[g];
}

/* Each row's factors times the rows of `combination`, HR_GROUPS groups of columns wide; a work-item a row. Many
   factors may be 0: of many lamps few light a row. */
__kernel void combine_columns(__global const float *factors,     /* (n_rows, n_factors)        */
                              __global const float *combination, /* (n_factors, 8 HR_GROUPS)   */
                              __global float *combined,          /* (n_rows, 8 HR_GROUPS)      */
                              const uint n_factors, const uint n_items)
{
    const uint row = get_global_id(0);
    if (row >= n_items)
        return;
    float8 sum[HR_GROUPS];
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] = (float8)(0.0f);
    for (uint k = 0; k < n_factors; ++k) {
        const float factor = factors[(size_t)row * n_factors + k];
        if (factor == 0.0f)
            continue;
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            sum[g] += factor * ((hr_groups_in)combination)[(size_t)k * HR_GROUPS + g];
    }
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)combined)[(size_t)row * HR_GROUPS + g] = sum[g];
}
