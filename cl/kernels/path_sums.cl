/* Spectra of paths: what each met, times paints, lamps and the solution where it ends. */
#include "include/hr_columns.h"
#include "include/hr_outcomes.h"
#include "include/hr_types.h"

/* Reflected part of readings: sums over batches of paths of rho1 (D1 + rho2 (D2 + ... rho E)), with the light D at each
   hit that was lit explicitly and the solution at the last one. The sky shines where a path leaves. With HR_GLOW, paints
   that shine add their own exitance at each hit; at the last, `reflected` holds it. */
__kernel void sum_paths(__global const uint *path_start,     /* (n_batches + 1,) into the paths                */
                        __global const uint *path_paint,     /* (n_paths, HR_LIT_HITS)                         */
                        __global const uint *path_emitter,   /* (n_paths, HR_LIT_HITS)                         */
                        __global const float *path_gain,     /* (n_paths, HR_LIT_HITS)                         */
                        __global const uint *path_row,       /* (n_paths,)                                     */
                        __global const float *path_weight,   /* (n_paths,)                                     */
                        __global const float *reflectance,   /* (n_paints, 8 n_groups) [1]                     */
                        __global const float *glow,          /* (n_paints, 8 n_groups) [W m^-2], with HR_GLOW  */
                        __global const float *emission,      /* (n_emitters, 8 n_groups) [W m^-2] or [W sr^-1] */
                        __global const float *reflected,     /* (n_rows, 8 n_groups) leaving [W m^-2]          */
                        __global const float *sky,           /* (8 n_groups,) pi L [W m^-2]                    */
                        __global const float *weight,        /* (8 n_groups,) of a path's brightness           */
                        __global float *irradiance,          /* (n_batches, 8 n_groups) [W m^-2]               */
                        __global float *brightness,          /* (n_batches, 2) sums of a path's and its square */
                        const uint n_items)
{
    const uint batch = get_global_id(0);
    if (batch >= n_items)
        return;
    float8 sum[HR_GROUPS];
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] = (float8)(0.0f);
    float bright_sum = 0.0f, bright_squares = 0.0f;
    const uint end = path_start[batch + 1];
    for (uint i = path_start[batch]; i < end; ++i) {
        const size_t first = (size_t)i * HR_LIT_HITS;
        const uint row = path_row[i];
        uint lit = 0;
        for (; lit < HR_LIT_HITS && path_paint[first + lit] != HR_NONE; ++lit)
            ;
        hr_groups_in last = (hr_groups_in)(HR_IS_ROW(row) ? reflected + (size_t)row * HR_GROUPS * 8 : sky);
        const float shines = HR_IS_ROW(row) || row == HR_SKY ? 1.0f : 0.0f;
        float8 arriving[HR_GROUPS];
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            arriving[g] = shines * last[g];
        for (uint back = lit; back > 0; --back) {
            const size_t at = first + back - 1;
            hr_groups_in lamp = (hr_groups_in)emission + (size_t)path_emitter[at] * HR_GROUPS;
            hr_groups_in paint = (hr_groups_in)reflectance + (size_t)path_paint[at] * HR_GROUPS;
            const float gain = path_gain[at];
#pragma unroll
            for (uint g = 0; g < HR_GROUPS; ++g)
                arriving[g] = paint[g] * (gain * lamp[g] + arriving[g]);
#if HR_GLOW
            hr_groups_in own = (hr_groups_in)glow + (size_t)path_paint[at] * HR_GROUPS;
#pragma unroll
            for (uint g = 0; g < HR_GROUPS; ++g)
                arriving[g] += own[g];
#endif
        }
        float8 bright = (float8)(0.0f);
        const float path_counts = path_weight[i];
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g) {
            arriving[g] *= path_counts;
            sum[g] += arriving[g];
            bright += ((hr_groups_in)weight)[g] * arriving[g];
        }
        const float path = (bright.s0 + bright.s1) + (bright.s2 + bright.s3) + (bright.s4 + bright.s5) +
                           (bright.s6 + bright.s7);
        bright_sum += path;
        bright_squares += path * path;
    }
    brightness[2 * batch] = bright_sum;
    brightness[2 * batch + 1] = bright_squares;
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)irradiance)[(size_t)batch * HR_GROUPS + g] = sum[g];
}

/* What readings would gain if the solution were `change` brighter where paths look it up: sums over batches of paths of
   rho1 rho2 ... change. */
__kernel void sum_lookups(__global const uint *path_start,   /* (n_batches + 1,) into the paths  */
                          __global const uint *path_paint,   /* (n_paths, HR_LIT_HITS)           */
                          __global const uint *path_row,     /* (n_paths,)                       */
                          __global const float *path_weight, /* (n_paths,)                       */
                          __global const float *reflectance, /* (n_paints, 8 n_groups) [1]       */
                          __global const float *change,      /* (n_rows, 8 n_groups) [W m^-2]    */
                          __global float *irradiance,        /* (n_batches, 8 n_groups) [W m^-2] */
                          const uint n_items)
{
    const uint batch = get_global_id(0);
    if (batch >= n_items)
        return;
    float8 sum[HR_GROUPS];
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] = (float8)(0.0f);
    const uint end = path_start[batch + 1];
    for (uint i = path_start[batch]; i < end; ++i) {
        const size_t first = (size_t)i * HR_LIT_HITS;
        const uint row = path_row[i];
        if (!HR_IS_ROW(row))
            continue;
        hr_groups_in last = (hr_groups_in)change + (size_t)row * HR_GROUPS;
        float8 arriving[HR_GROUPS];
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            arriving[g] = path_weight[i] * last[g];
        for (uint hit = 0; hit < HR_LIT_HITS && path_paint[first + hit] != HR_NONE; ++hit) {
            hr_groups_in paint = (hr_groups_in)reflectance + (size_t)path_paint[first + hit] * HR_GROUPS;
#pragma unroll
            for (uint g = 0; g < HR_GROUPS; ++g)
                arriving[g] *= paint[g];
        }
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            sum[g] += arriving[g];
    }
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)irradiance)[(size_t)batch * HR_GROUPS + g] = sum[g];
}
