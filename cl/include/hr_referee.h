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

/* First of n ascending sums that is greater than u; the last one if none is. */
inline uint hr_draw_lamp(__global const float *sums, const uint n, const float u)
{
    uint i = 0;
    while (i + 1 < n && u >= sums[i])
        ++i;
    return i;
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

/* Largest lane of the groups. */
inline float hr_largest(const float8 *groups, const uint n)
{
    float8 most = groups[0];
    for (uint g = 1; g < n; ++g)
        most = groups[g] > most ? groups[g] : most;
    const float4 a = most.lo > most.hi ? most.lo : most.hi;
    const float2 b = a.lo > a.hi ? a.lo : a.hi;
    return b.x > b.y ? b.x : b.y;
}

#endif
