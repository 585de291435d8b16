/* Products with spectra: band-free transport times (rows, columns) arrays, eight columns at a time. */
#include "include/hr_types.h"

/* Eight columns at a time through aligned pointers: PoCL calls vload8 and vstore8 as functions. */
typedef __global const float8 *hr_groups_in;
typedef __global float8 *hr_groups_out;
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
        hr_groups_in source = (hr_groups_in)columns + (size_t)link_source[l] * HR_GROUPS;
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            sum[g] += value * source[g];
    }
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)product)[(size_t)row * HR_GROUPS + g] = sum[g];
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
        const uint2 material = (uint2)(path_material[2 * i], path_material[2 * i + 1]);
        const int lit = material.x != HR_NONE;
        const int lit_again = material.y != HR_NONE;
        const size_t first = 2 * i, second = 2 * i + 1;
        const float gain = lit ? path_gain[first] : 0.0f;
        const float gain_again = lit_again ? path_gain[second] : 0.0f;
        hr_groups_in lamp = (hr_groups_in)emission + (lit ? (size_t)path_emitter[first] * HR_GROUPS : 0);
        hr_groups_in lamp_again = (hr_groups_in)emission + (lit_again ? (size_t)path_emitter[second] * HR_GROUPS : 0);
        hr_groups_in paint = (hr_groups_in)reflectance + (lit ? (size_t)material.x * HR_GROUPS : 0);
        hr_groups_in paint_again = (hr_groups_in)reflectance + (lit_again ? (size_t)material.y * HR_GROUPS : 0);
        hr_groups_in last = (hr_groups_in)(HR_IS_ROW(row) ? reflected + (size_t)row * HR_GROUPS * 8 : sky);
        const float shines = HR_IS_ROW(row) || row == HR_SKY ? 1.0f : 0.0f;
        float8 bright = (float8)(0.0f);
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g) {
            float8 arriving = shines * last[g];
            if (lit_again)
                arriving = paint_again[g] * (gain_again * lamp_again[g] + arriving);
            if (lit)
                arriving = paint[g] * (gain * lamp[g] + arriving);
            sum[g] += arriving;
            bright += ((hr_groups_in)weight)[g] * arriving;
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
        ((hr_groups_out)irradiance)[(size_t)point * HR_GROUPS + g] = sum[g] / (float)n_samples;
}
