/* Steps of unbiased paths. Light from area emitters is found in two ways, by a point drawn on the emitter and by the
   ray that goes on; the balance heuristic weighs them (Veach & Guibas 1995). A direction drawn with cos/pi has the
   density k = cos cos / (pi r^2) per area of the emitter, which is the form-factor kernel itself, and a point drawn on
   it has chance / A. So either way counts A k / (chance + A k), which is at most 1 however near the lamp is. */
#ifndef HR_REFEREE_H
#define HR_REFEREE_H

#include "include/hr_bvh.h"
#include "include/hr_emitters.h"
#include "include/hr_sampling.h"

inline float hr_patch_area(const uint patch, HR_PATCH_PARAMS)
{
    const float3 c = cross(hr_load3(patch_edge_u, patch), hr_load3(patch_edge_v, patch));
    return (patch_kind[patch] ? 0.5f : 1.0f) * sqrt(dot(c, c));
}

/* A k / (chance + A k) for the point at offset d from a surface with unit normal n, on an emitting side with area
   `area` and unit normal m. chance > 0: emitter points drawn for each direction drawn. [1] */
inline float hr_balanced_gain(const float3 n, const float3 d, const float3 m, const float area, const float chance)
{
    const float arriving = area * hr_point_kernel(n, d, m);
    return arriving / (chance + arriving);
}

/* Light at x from the point (s, t) of one emitter, for unit exitance or unit intensity, over the chance that the
   emitter is drawn, with the balance heuristic's weight. 0 if something is between. */
inline float hr_lamp_gain(const float3 x, const float3 n, const uint own, const uint emitter, const float chance,
                          const float s, const float t, const float scale, HR_EMITTER_PARAMS, HR_PATCH_PARAMS,
                          HR_BVH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    if (patch != HR_NONE && patch == own)
        return 0.0f;
    const float3 y = hr_emitter_point(emitter, s, t, HR_EMITTER, HR_PATCH);
    const float3 d = y - x;
    float gain;
    if (patch == HR_NONE) {
        const float r2 = fmax(dot(d, d), 1.0e-30f);
        gain = fmax(dot(n, d), 0.0f) / (r2 * sqrt(r2) * chance);
    } else {
        const float3 m = hr_emitter_normal(patch, emitter_two_sided[emitter], x, HR_PATCH);
        gain = hr_balanced_gain(n, d, m, hr_patch_area(patch, HR_PATCH), chance);
    }
    if (gain <= 0.0f)
        return 0.0f;
    const float3 origin = hr_offset_origin(x, n, scale);
    return hr_any_hit(HR_BVH, origin, y - origin, 1.0f, own, patch) ? 0.0f : gain;
}

/* About how much light of an emitter reaches x, from its power and a point in its middle; the tenth added to the cosines and the
   size added to the distance keep it above 0 for all that can arrive. Only decides how often it is drawn. */
inline float hr_lamp_guess(const float3 x, const float3 n, const uint emitter, __global const float *emitter_power,
                           HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    const uint patch = emitter_patch[emitter];
    const float3 d = hr_emitter_point(emitter, 0.5f, 0.5f, HR_EMITTER, HR_PATCH) - x;
    const float r2 = dot(d, d) + 1.0e-12f;
    const float near = 1.0f / sqrt(r2);
    const float arriving = emitter_power[emitter] * (fmax(dot(n, d) * near, 0.0f) + 0.1f);
    if (patch == HR_NONE)
        return arriving / r2;
    const float leaving = -dot(hr_load3(patch_normal, patch), d) * near;
    const float shining = emitter_two_sided[emitter] ? fabs(leaving) : fmax(leaving, 0.0f);
    return arriving * (shining + 0.1f) / (r2 + hr_patch_area(patch, HR_PATCH));
}

/* Chance that hr_draw_lamp takes an emitter with that guess, of n whose guesses add up to `total`. */
inline float hr_lamp_chance(const float guess, const float total, const uint n)
{
    return total > 0.0f ? 0.9f * guess / total + 0.1f / (float)n : 1.0f / (float)n;
}

/* Draws one of n emitters with the number u; `total` gets the sum of their guesses. */
inline uint hr_draw_lamp(const float3 x, const float3 n, const uint n_emitters, float u, float *total,
                         __global const float *emitter_power, HR_EMITTER_PARAMS, HR_PATCH_PARAMS)
{
    float sum = 0.0f;
    uint drawn = 0;
    float number = u / 0.9f;
    for (uint e = 0; e < n_emitters; ++e) {
        const float guess = hr_lamp_guess(x, n, e, emitter_power, HR_EMITTER, HR_PATCH);
        sum += guess;
        const float share = sum > 0.0f ? guess / sum : 0.0f;
        /* A reservoir of one: what is left of the number decides about the next. */
        const int taken = number < share;
        drawn = taken ? e : drawn;
        number = taken ? number / share : (number - share) / (1.0f - share);
    }
    *total = sum;
    if (u < 0.9f && sum > 0.0f)
        return drawn;
    const float even = sum > 0.0f ? (u - 0.9f) * 10.0f : u;
    return min((uint)(even * (float)n_emitters), n_emitters - 1);
}

/* Number `counter` of the stream that `seed` starts, in [0, 1). */
inline float hr_random(const uint seed, const uint counter)
{
    return hr_unit_float(hr_combine(seed, counter));
}

/* Number `place` (0, 1: direction; 2, 3: point on the lamp; 4: which lamp; 5: roulette) of bounce `depth` of path k.
   The Sobol sequence has eight coordinates: they go to the first bounce and to the start of the second. */
inline float hr_path_number(const uint k, const uint depth, const uint place, const uint seed)
{
    const uint dimension = depth == 0 ? place : depth == 1 && place < 2 ? 5 + place : depth == 1 && place == 4 ? 7 : 8;
    if (place < 5 && dimension < HR_SOBOL_DIMENSIONS)
        return hr_sample(k, dimension, seed);
    return hr_random(hr_combine(seed ^ 0xa511e9b3u, k), 8 * depth + place);
}

#ifdef HR_GROUPS
/* sum += gain * weight * row of a table of spectra; eight bands at a time. */
inline void hr_add_light(float8 *sum, const float gain, const float8 *weight, __global const float *table,
                         const uint row)
{
    for (uint g = 0; g < HR_GROUPS; ++g)
        sum[g] += gain * weight[g] * vload8((size_t)row * HR_GROUPS + g, table);
}

inline void hr_fill(float8 *weight, const float value)
{
    for (uint g = 0; g < HR_GROUPS; ++g)
        weight[g] = (float8)(value);
}

/* Multiplies the weight with a row of a table of reflectances; returns its largest band. */
inline float hr_reflect(float8 *weight, __global const float *table, const uint row)
{
    float8 most = (float8)(0.0f);
    for (uint g = 0; g < HR_GROUPS; ++g) {
        weight[g] *= vload8((size_t)row * HR_GROUPS + g, table);
        most = weight[g] > most ? weight[g] : most;
    }
    const float4 a = most.lo > most.hi ? most.lo : most.hi;
    const float2 b = a.lo > a.hi ? a.lo : a.hi;
    return b.x > b.y ? b.x : b.y;
}
#endif

#endif
