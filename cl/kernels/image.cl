/* Images: what the pixels of a picture see, with direct light computed there and reflected light gathered from the
   solution. All bands. */
#include "include/hr_camera.h"
#include "include/hr_guide.h"
#include "include/hr_image.h"
#include "include/hr_image_spectra.h"
#include "include/hr_path_steps.h"

/* Hits of a gathering path that are lit explicitly, at most; as in readings. */
#define HR_MOST_HITS 32u

/* Gathering paths from each point: a path costs less than the point and its shadow ray, and brings more noise. */
#define HR_PATHS 2u

/* Places of a pixel's sums: X, Y, Z of what does not shine, illuminance, X, Y, Z of what shines or lies beyond the
   scene, samples of that, samples on surfaces. As in hradiosity/show/image_pixels.py. */
#define HR_SUM_DULL 0u
#define HR_SUM_LUX 3u
#define HR_SUM_BRIGHT 4u
#define HR_SUM_SHINING 7u
#define HR_SUM_SURFACE 8u
#define HR_SUMS 9u

/* Sums over the samples of pixels, spread evenly over each. At the point that a sample shows, one lamp is tried, and
   HR_PATHS paths gather reflected light until they look the solution up, as paths of readings do; they start along the
   guide of the row element that they leave, if it has one. With HR_SPECTRA sums of the exitance spectra too. */
__kernel void image_samples(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_EMITTER_PARAMS,
                            __global const uint *cell_divisions,  /* see HR_ELEMENT_PARAMS                      */
                            __global const uint *side_first_cell, /* the same                                   */
                            __global const uint *cell_row,        /* the same                                   */
                            __global const float *camera,         /* (4, 3): position [m], local; forward, right, down */
                            __global const uint *patch_solid,     /* (n_patches,) not 0: matter behind it       */
                            __global const uint *side_paint,      /* (n_patches, 2)                             */
                            __global const uint *side_lamp,       /* (n_patches, 2) luminaire, or HR_NONE       */
                            __global const float *row_size,       /* (n_rows,) edge of each element [m]; INFINITY: no lookup;
                                                                     below 0: lookup at the first hit already   */
                            __global const float *lamp_choice,    /* (n_rows, n_emitters) summed probabilities  */
                            __global const uchar *lamp_clear,     /* (n_rows, n_emitters) 1: counts by its closed form */
                            __global const uint *clear_lamps,     /* (n_rows, HR_CLEAR_LAMPS) the same as a list, HR_NONE
                                                                     behind the last                            */
                            __global const uint *row_guide,       /* (n_rows,) number of its guide, or HR_NONE  */
                            __global const float *guide,          /* (n_guides, HR_GUIDE_ENTRIES)               */
                            __global const float *reflectance,    /* (n_paints, 8 n_groups) [1]                 */
                            __global const float *glow,           /* (n_paints, 8 n_groups) exitance of weak lamps [W m^-2] */
                            __global const float *shown,          /* (n_luminaires, 8 n_groups) exitance [W m^-2] */
                            __global const float *emission,       /* (n_emitters, 8 n_groups) [W m^-2], [W sr^-1] */
                            __global const float *reflected,      /* (n_rows, 8 n_groups) leaving [W m^-2]      */
                            __global const float *sky,            /* (8 n_groups,) pi L [W m^-2]                */
                            __global const float *colour,         /* (4, 8 n_groups) X, Y, Z of a radiance for its
                                                                     exitance; illuminance                      */
                            __global float *pixel_sums,           /* (n_items, HR_SUMS)                         */
                            __global float *spectra,              /* (n_items, 8 n_groups) exitance, with HR_SPECTRA */
                            const uint width, const uint height, const uint levels, const uint first_pixel,
                            const uint n_samples, const uint n_emitters, const uint occlusion, const uint gathers,
                            const float bounce, const float near_factor, const float first_near_factor,
                            const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint px = (first_pixel + i) % width;
    const uint py = (first_pixel + i) / width;
    const uint first = hr_pixel_order(px, py, levels, hr_combine(seed, 0x2545f491u)) * n_samples;
    const float3 eye = hr_load3(camera, 0);
    float sums[HR_SUMS];
#pragma unroll
    for (uint c = 0; c < HR_SUMS; ++c)
        sums[c] = 0.0f;
#if HR_SPECTRA
    float8 whole[HR_GROUPS];
    hr_set(whole, 0.0f);
#endif

    for (uint k = first; k < first + n_samples; ++k) {
        float8 light[HR_GROUPS], weight[HR_GROUPS];
        hr_set(light, 0.0f);
        hr_set(weight, 1.0f);
        float3 d = hr_view_direction(((float)px + hr_sample(k, 0, seed)) / (float)width,
                                     ((float)py + hr_sample(k, 1, seed)) / (float)height, hr_load3(camera, 1),
                                     hr_load3(camera, 2), hr_load3(camera, 3));
        hr_hit hit = hr_closest_hit(HR_BVH, eye, d, INFINITY, HR_NONE);
        const int leaves = hit.patch == HR_NONE;
        const uint seen = leaves ? 0 : 2u * hit.patch + hit.side;
        uint row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
        if (row == HR_SKY)
            hr_add_spectrum(light, 1.0f, weight, sky, 0);
        if (HR_IS_ROW(row) || row == HR_UNLIT) {
            const uint first_row = row, first_own = hit.patch;
            const uint guided = HR_IS_ROW(row) ? row_guide[row] : HR_NONE;
            const float3 x0 = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
            const float3 n0 = hr_side_normal(hit.patch, hit.side, patch_normal);
            hr_tried_lamp straight =
                hr_try_lamp(x0, n0, first_own, first_row,
                                 (float3)(hr_sample(k, 4, seed), hr_sample(k, 5, seed), hr_sample(k, 6, seed)),
                                 lamp_choice, lamp_clear, n_emitters, occlusion, scale, HR_EMITTER, HR_PATCH, HR_BVH);
            for (uint path = k * HR_PATHS; path < (k + 1) * HR_PATHS && (gathers || straight.near); ++path) {
                float3 start = (float3)(hr_sample(path, 2, seed), hr_sample(path, 3, seed), 1.0f);
                if (guided != HR_NONE)
                    start = hr_guide(guide + (size_t)guided * HR_GUIDE_ENTRIES, start.x, start.y);
                const float counts = start.z / (float)HR_PATHS;
                d = hr_cosine_direction(n0, start.x, start.y);
                hit = hr_closest_hit(HR_BVH, hr_offset_origin(x0, n0, scale), d, INFINITY, first_own);
                if (straight.near)
                    straight.gain +=
                        counts * hr_found_on_ray(x0, n0, d, hit.patch, hit.t, straight.emitter, straight.clear,
                                                 HR_EMITTER, HR_PATCH);
                if (!gathers)
                    continue;
                hr_set(weight, counts);
                const uint plain = hr_combine(seed ^ 0x51ed270bu, path);
                for (uint step = 0; step < HR_MOST_HITS; ++step) {
                    row = hr_row_of_hit(hit, d, patch_solid, cell_divisions, side_first_cell, cell_row, patch_kind);
                    if (row == HR_SKY)
                        hr_add_spectrum(light, 1.0f, weight, sky, 0);
                    if (!HR_IS_ROW(row) && row != HR_UNLIT)
                        break;
                    const float size = HR_IS_ROW(row) ? row_size[row] : INFINITY;
                    if (hit.t >= (step == 0 && size >= 0.0f ? first_near_factor : near_factor) * hr_magnitude(size)) {
                        hr_add_spectrum(light, 1.0f, weight, reflected, row);
                        break;
                    }
                    const float3 x = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
                    const float3 n = hr_side_normal(hit.patch, hit.side, patch_normal);
                    const uint own = hit.patch;
                    const uint paint = side_paint[2u * own + hit.side];
                    hr_add_spectrum(light, 1.0f, weight, glow, paint);
                    hr_multiply(weight, bounce, reflectance, paint);
                    /* Fewer and weaker paths come here: plain random numbers serve them. */
                    const uint place = 5u * step;
                    hr_tried_lamp lamp = hr_try_lamp(
                        x, n, own, row, (float3)(hr_plain(plain, place), hr_plain(plain, place + 1), hr_plain(plain, place + 2)),
                        lamp_choice, lamp_clear, n_emitters, occlusion, scale, HR_EMITTER, HR_PATCH, HR_BVH);
                    d = hr_cosine_direction(n, hr_plain(plain, place + 3), hr_plain(plain, place + 4));
                    hit = hr_closest_hit(HR_BVH, hr_offset_origin(x, n, scale), d, INFINITY, own);
                    if (lamp.near)
                        lamp.gain += hr_found_on_ray(x, n, d, hit.patch, hit.t, lamp.emitter, lamp.clear, HR_EMITTER,
                                                     HR_PATCH);
                    hr_add_clear_lamps(light, weight, x, n, own, row, clear_lamps, emission, HR_EMITTER, HR_PATCH);
                    hr_add_spectrum(light, lamp.gain / lamp.probability, weight, emission, lamp.emitter);
                }
            }
            hr_set(weight, 1.0f);
            hr_add_clear_lamps(light, weight, x0, n0, first_own, first_row, clear_lamps, emission, HR_EMITTER, HR_PATCH);
            hr_add_spectrum(light, straight.gain / straight.probability, weight, emission, straight.emitter);
        }
        if (!leaves) {
            sums[HR_SUM_LUX] += hr_weighted(colour, 3, light);
            sums[HR_SUM_SURFACE] += 1.0f;
            hr_multiply(light, 1.0f, reflectance, side_paint[seen]);
            if (side_lamp[seen] != HR_NONE)
                hr_add_spectrum(light, 1.0f, weight, shown, side_lamp[seen]);
        }
        const int shines = leaves || side_lamp[seen] != HR_NONE;
        sums[HR_SUM_SHINING] += shines ? 1.0f : 0.0f;
        for (uint c = 0; c < 3; ++c)
            sums[(shines ? HR_SUM_BRIGHT : HR_SUM_DULL) + c] += hr_weighted(colour, c, light);
#if HR_SPECTRA
#pragma unroll
        for (uint g = 0; g < HR_GROUPS; ++g)
            whole[g] += light[g];
#endif
    }
#pragma unroll
    for (uint c = 0; c < HR_SUMS; ++c)
        pixel_sums[(size_t)i * HR_SUMS + c] = sums[c];
#if HR_SPECTRA
#pragma unroll
    for (uint g = 0; g < HR_GROUPS; ++g)
        ((hr_groups_out)spectra)[(size_t)i * HR_GROUPS + g] = whole[g];
#endif
}
