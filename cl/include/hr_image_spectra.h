/* Spectra of images: eight bands at a time, HR_GROUPS times. */
#ifndef HR_IMAGE_SPECTRA_H
#define HR_IMAGE_SPECTRA_H

#include "include/hr_columns.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"

HR_FORCE_INLINE void hr_set(float8 *spectrum, const float value)
{
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        spectrum[g] = (float8)(value);
}

/* spectrum *= factor * row of a table. */
HR_FORCE_INLINE void hr_multiply(float8 *spectrum, const float factor, __global const float *table, const uint row)
{
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        spectrum[g] *= factor * ((hr_groups_in)table)[(size_t)row * HR_GROUPS + g];
}

/* light += gain * weight * row of a table. */
HR_FORCE_INLINE void hr_add_spectrum(float8 *light, const float gain, const float8 *weight,
                                     __global const float *table, const uint row)
{
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        light[g] += gain * weight[g] * ((hr_groups_in)table)[(size_t)row * HR_GROUPS + g];
}

/* Sum over the bands of a row of a table times the light. */
HR_FORCE_INLINE float hr_weighted(__global const float *table, const uint row, const float8 *light)
{
    float8 sum = (float8)(0.0f);
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum += ((hr_groups_in)table)[(size_t)row * HR_GROUPS + g] * light[g];
    const float4 pairs = sum.lo + sum.hi;
    return (pairs.x + pairs.y) + (pairs.z + pairs.w);
}

/* Adds what the clear lamps of a row send to a point by their closed forms. */
HR_FORCE_INLINE void hr_add_clear_lamps(float8 *light, const float8 *weight, const float3 x, const float3 n,
                                        const uint own, const uint row, __global const uint *clear_lamps,
                                        __global const float *emission, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    if (!HR_IS_ROW(row))
        return;
    __global const uint *lamps = clear_lamps + (size_t)row * HR_CLEAR_LAMPS;
    for (uint k = 0; k < HR_CLEAR_LAMPS && lamps[k] != HR_NONE; ++k)
        if (emitter_patch[lamps[k]] != own || own == HR_NONE)
            hr_add_spectrum(light, hr_emitter_factor(x, n, lamps[k], HR_EMITTER, HR_PATCH), weight, emission, lamps[k]);
}

#endif
