/* Products with spectra: band-free transport times (rows, columns) arrays, eight columns at a time. */
#include "include/hr_types.h"
#include "include/hr_outcomes.h"

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
        const size_t source = (size_t)link_source[l] * HR_GROUPS;
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            sum[g] += value * vload8(source + g, columns);
    }
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        vstore8(sum[g], (size_t)row * HR_GROUPS + g, product);
}

/* Reflected part of each reading: mean over its paths of rho1 (D1 + rho E at the second hit), or, where the second
   hit was lit explicitly, of rho1 (D1 + rho2 (D2 + rho E at the third)). The sky shines where a path leaves. */
__kernel void sum_paths(__global const uint *path_material,  /* (n_points, n_samples, 2)                       */
                        __global const uint *path_emitter,   /* (n_points, n_samples, 2)                       */
                        __global const float *path_gain,     /* (n_points, n_samples, 2)                       */
                        __global const uint *path_row,       /* (n_points, n_samples)                          */
                        __global const float *reflectance,   /* (n_materials, 8 n_groups) [1]                  */
                        __global const float *emission,      /* (n_emitters, 8 n_groups) [W m^-2] or [W sr^-1] */
                        __global const float *reflected,     /* (n_rows, 8 n_groups) rho E [W m^-2]            */
                        __global const float *sky,           /* (8 n_groups,) pi L [W m^-2]                    */
                        __global const float *weight,        /* (8 n_groups,) of a path's brightness           */
                        __global float *irradiance,          /* (n_points, 8 n_groups) [W m^-2]                */
                        __global float *brightness,          /* (n_points, 2) sums of a path's and its square  */
                        const uint n_samples, const uint n_items)
{
    const uint point = get_global_id(0);
    if (point >= n_items)
        return;
    float8 sum[HR_GROUPS];
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] = (float8)(0.0f);
    float bright_sum = 0.0f, bright_squares = 0.0f;
    for (uint k = 0; k < n_samples; ++k) {
        const size_t i = (size_t)point * n_samples + k;
        const uint row = path_row[i];
        const uint2 material = vload2(i, path_material);
        const int lit = material.x != HR_NONE;
        const int lit_again = material.y != HR_NONE;
        const uint2 emitter = lit ? vload2(i, path_emitter) : (uint2)(0);
        const float2 gain = lit ? vload2(i, path_gain) : (float2)(0.0f);
        __global const float *last = HR_IS_ROW(row) ? reflected + (size_t)row * HR_GROUPS * 8 : sky;
        const float shines = HR_IS_ROW(row) || row == HR_SKY ? 1.0f : 0.0f;
        float8 bright = (float8)(0.0f);
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g) {
            float8 arriving = shines * vload8(g, last);
            if (lit_again) {
                arriving += gain.y * vload8((size_t)emitter.y * HR_GROUPS + g, emission);
                arriving *= vload8((size_t)material.y * HR_GROUPS + g, reflectance);
            }
            if (lit) {
                arriving += gain.x * vload8((size_t)emitter.x * HR_GROUPS + g, emission);
                arriving *= vload8((size_t)material.x * HR_GROUPS + g, reflectance);
            }
            sum[g] += arriving;
            bright += vload8(g, weight) * arriving;
        }
        const float path = (bright.s0 + bright.s1) + (bright.s2 + bright.s3) + (bright.s4 + bright.s5) +
                           (bright.s6 + bright.s7);
        bright_sum += path;
        bright_squares += path * path;
    }
    brightness[2 * point] = bright_sum;
    brightness[2 * point + 1] = bright_squares;
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        vstore8(sum[g] / (float)n_samples, (size_t)point * HR_GROUPS + g, irradiance);
}
