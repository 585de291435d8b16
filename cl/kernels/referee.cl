/* Unbiased paths from readings, all bands at once; they share rays, emitters and random numbers with the solver, and
   neither elements nor exchange. */
#ifndef HR_GROUPS
#error "HR_GROUPS must be set by the host: groups of eight bands"
#endif

#include "include/hr_referee.h"
#include "include/hr_response.h"

/* Paths up to this bounce end only where nothing is reflected. */
#define HR_ROULETTE_FROM 2u
/* Nor before they have lost so much: in bright rooms, how often a path is reflected would be most of the noise. */
#define HR_ROULETTE_BELOW 0.25f

/* Light that comes straight from each emitter: sums over samples first_sample ... first_sample + n_samples - 1. */
__kernel void referee_direct(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                             __global const float *position, /* (n_points, 3) [m]                                */
                             __global const float *normal,   /* (n_points, 3) unit                               */
                             __global const float *response, /* (n_points, HR_RESPONSE_ENTRIES), with HR_RESPONSE */
                             __global float *direct,         /* (n_points, n_scrambles, n_emitters) [1], [m^-2]  */
                             const uint n_scrambles, const uint n_emitters, const uint first_sample,
                             const uint n_samples, const float direct_chance, const uint seed, const float scale,
                             const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint emitter = i % n_emitters;
    const uint scramble = i / n_emitters % n_scrambles;
    const uint point = i / n_emitters / n_scrambles;
    const uint lamp_seed = hr_combine(hr_combine(hr_combine(seed, point), scramble), emitter);
    const float3 x = hr_load3(position, point);
    const float3 n = hr_load3(normal, point);
    const uint is_point = emitter_patch[emitter] == HR_NONE;
    const uint rays = is_point ? 1 : n_samples;
    float sum = 0.0f;
    for (uint k = first_sample; k < first_sample + rays; ++k) {
        const float s = hr_sample(k, 0, lamp_seed), t = hr_sample(k, 1, lamp_seed);
        float gain = hr_lamp_gain(x, n, HR_NONE, emitter, is_point ? 1.0f : direct_chance, s, t, scale, HR_EMITTER,
                                  HR_PATCH, HR_BVH);
#if HR_RESPONSE
        const float3 d = hr_emitter_point(emitter, s, t, HR_EMITTER, HR_PATCH) - x;
        gain *= hr_response(response, point, d / sqrt(hr_dot(d, d)));
#endif
        sum += gain;
    }
    direct[i] = is_point ? sum * (float)n_samples : sum * direct_chance;
}

/* What comes over the paths first_path ... first_path + n_paths - 1 of each point and scramble, as sums. Emitters
   that the first ray meets count here by the part that referee_direct leaves them. */
__kernel void referee_paths(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                            __global const float *position,       /* (n_points, 3) [m]                            */
                            __global const float *normal,         /* (n_points, 3) unit                           */
                            __global const float *response,       /* (n_points, HR_RESPONSE_ENTRIES), with HR_RESPONSE */
                            __global const uint *side_material,   /* (n_patches, 2) HR_NONE: black                */
                            __global const uint *patch_solid,     /* (n_patches,) not 0: matter behind            */
                            __global const uint *patch_emitter,   /* (n_patches,) HR_NONE: emits nothing          */
                            __global const float *emitter_power,  /* (n_emitters,) in any unit                    */
                            __global const float *reflectance,    /* (n_materials, 8 HR_GROUPS) [1]               */
                            __global const float *emission,       /* (n_emitters, 8 HR_GROUPS) [W m^-2], [W sr^-1] */
                            __global const float *sky,            /* (8 HR_GROUPS,) pi L [W m^-2]                 */
                            __global float *irradiance,           /* (n_items, 8 HR_GROUPS) [W m^-2]              */
                            __global float *tally, /* (n_items, 3) paths that began inside a solid; weight left at the
                                                      depth limit; rays                                           */
                            const uint n_scrambles, const uint n_chunks, const uint n_emitters, const uint first_path,
                            const uint n_paths, const float direct_chance, const uint depth_limit, const uint seed,
                            const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint chunk = i % n_chunks;
    const uint scramble = i / n_chunks % n_scrambles;
    const uint point = i / n_chunks / n_scrambles;
    const uint path_seed = hr_combine(hr_combine(seed ^ 0x68bc21ebu, point), scramble);
    float8 sum[HR_GROUPS], weight[HR_GROUPS];
    hr_fill(sum, 0.0f);
    float3 counts = (float3)(0.0f);

    for (uint k = first_path + chunk; k < first_path + n_paths; k += n_chunks) {
        float3 x = hr_load3(position, point);
        float3 n = hr_load3(normal, point);
        uint own = HR_NONE;
        float most = 1.0f, guesses = 0.0f;
        hr_fill(weight, 1.0f);
        for (uint depth = 0;; ++depth) {
            const float3 d = hr_cosine_direction(n, hr_path_number(k, depth, 0, path_seed),
                                                 hr_path_number(k, depth, 1, path_seed));
            const hr_hit hit = hr_closest_hit(HR_BVH, hr_offset_origin(x, n, scale), d, INFINITY, own);
            counts.z += 1.0f;
#if HR_RESPONSE
            if (depth == 0)
                hr_fill(weight, hr_response(response, point, d));
#endif
            if (hit.patch == HR_NONE) {
                if (d.z > 0.0f)
                    hr_add_light(sum, 1.0f, weight, sky, 0);
                break;
            }
            const float3 y = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
            const float3 m = hr_side_normal(hit.patch, hit.side, patch_normal);
            const uint met = patch_emitter[hit.patch];
            if (met != HR_NONE && (hit.side == HR_FRONT || emitter_two_sided[met])) {
                const float gain = hr_balanced_gain(n, y - x, m, hr_patch_area(hit.patch, HR_PATCH),
                                                    depth == 0 ? direct_chance
                                                               : hr_lamp_chance(hr_lamp_guess(x, n, met, emitter_power,
                                                                                              HR_EMITTER, HR_PATCH),
                                                                                guesses, n_emitters));
                hr_add_light(sum, gain, weight, emission, met);
            }
            const uint material = side_material[2 * hit.patch + hit.side];
            if (material == HR_NONE) {
                if (depth == 0 && patch_solid[hit.patch])
                    counts.x += 1.0f;
                break;
            }
            const float before = most;
            most = hr_reflect(weight, reflectance, material);
            if (most <= 0.0f)
                break;
            if (depth + 1 >= depth_limit) {
                counts.y += most;
                break;
            }
            if (depth >= HR_ROULETTE_FROM && most < HR_ROULETTE_BELOW && most < before) {
                /* The weight stays where it was; going up to 1 again would make few paths carry much. */
                const float survival = most / before;
                if (hr_path_number(k, depth, 5, path_seed) >= survival)
                    break;
                for (uint g = 0; g < HR_GROUPS; ++g)
                    weight[g] /= survival;
                most = before;
            }
            x = y;
            n = m;
            own = hit.patch;
            if (n_emitters == 0)
                continue;
            const uint lamp = hr_draw_lamp(x, n, n_emitters, hr_path_number(k, depth, 4, path_seed), &guesses,
                                           emitter_power, HR_EMITTER, HR_PATCH);
            const float guess = hr_lamp_guess(x, n, lamp, emitter_power, HR_EMITTER, HR_PATCH);
            const float gain = hr_lamp_gain(x, n, own, lamp, hr_lamp_chance(guess, guesses, n_emitters),
                                            hr_path_number(k, depth, 2, path_seed),
                                            hr_path_number(k, depth, 3, path_seed), scale, HR_EMITTER, HR_PATCH,
                                            HR_BVH);
            counts.z += 1.0f;
            if (gain > 0.0f)
                hr_add_light(sum, gain, weight, emission, lamp);
        }
    }
    for (uint g = 0; g < HR_GROUPS; ++g)
        vstore8(sum[g], (size_t)i * HR_GROUPS + g, irradiance);
    vstore3(counts, i, tally);
}
