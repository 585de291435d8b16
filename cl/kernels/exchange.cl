/* Rays from row elements: the samples of the exchange between elements. */
#include "include/hr_aims.h"
#include "include/hr_row_rays.h"

/* Ray `k` of row `r` starts at the k-th point of the row's own sequence, with density cos/pi about the normal. */
__kernel void trace_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_SOLID_PARAMS,
                         __global uint *hit_row,  /* (n_rows, n_samples) row, or an outcome */
                         __global uint *hit_side, /* (n_rows, n_samples) 2 patch + side     */
                         const uint first_row, const uint n_samples, const uint seed, const float scale,
                         const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = first_row + i / n_samples;
    const uint k = i % n_samples;
    const uint row_seed = hr_combine(seed, row);
    const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed), HR_ELEMENT,
                                           HR_PATCH);
    const float3 direction =
        hr_cosine_direction(place.normal, hr_sample(k, 2, row_seed), hr_sample(k, 3, row_seed));
    const float3 origin = hr_offset_origin(place.position, place.normal, scale);
    const hr_hit hit = hr_closest_hit(HR_BVH, origin, direction, INFINITY, place.patch);
    hit_row[i] = hr_ray_outcome(hit, origin, direction, scale, cell_divisions, side_first_cell, cell_row, patch_kind,
                                patch_normal, HR_SOLID, HR_BVH);
    hit_side[i] = hit.patch == HR_NONE ? HR_NONE : 2 * hit.patch + hit.side;
}

/* The same with some rays aimed at spots. `hit_density` holds the density of the row's rays in that direction over the
   cosine law's, INFINITY for a ray that is lost since its spot lies below the horizon or around it, and the same for
   the rays of the row that is met, back along this one. */
__kernel void trace_aimed_rows(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS, HR_SOLID_PARAMS, HR_AIM_PARAMS,
                               __global uint *hit_row,      /* (n_rows, n_samples) row, or an outcome */
                               __global uint *hit_side,     /* (n_rows, n_samples) 2 patch + side     */
                               __global float *hit_density, /* (n_rows, n_samples, 2)                 */
                               const uint n_samples, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = i / n_samples;
    const uint k = i % n_samples;
    const uint row_seed = hr_combine(seed, row);
    const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed), HR_ELEMENT,
                                           HR_PATCH);
    const float u = hr_sample(k, 2, row_seed), v = hr_sample(k, 3, row_seed), choice = hr_sample(k, 4, row_seed);
    __global const float *sums = aim_sums + (size_t)row * n_spots;
    const float3 direction = choice < sums[n_spots - 1]
                                 ? hr_aimed_direction(hr_draw(sums, n_spots, choice), place.position, u, v, aim_spot)
                                 : hr_cosine_direction(place.normal, u, v);
    const float cosine = hr_dot(direction, place.normal);
    if (cosine <= 0.0f) {
        hit_row[i] = HR_MISS;
        hit_side[i] = HR_NONE;
        hit_density[2 * i] = hit_density[2 * i + 1] = INFINITY;
        return;
    }
    const float3 origin = hr_offset_origin(place.position, place.normal, scale);
    const hr_hit hit = hr_closest_hit(HR_BVH, origin, direction, INFINITY, place.patch);
    const uint outcome = hr_ray_outcome(hit, origin, direction, scale, cell_divisions, side_first_cell, cell_row,
                                        patch_kind, patch_normal, HR_SOLID, HR_BVH);
    hit_row[i] = outcome;
    hit_side[i] = hit.patch == HR_NONE ? HR_NONE : 2 * hit.patch + hit.side;
    hit_density[2 * i] = hr_aimed_density(row, place.position, direction, cosine, HR_AIM);
    float back = 0.0f;
    if (HR_IS_ROW(outcome)) {
        const float3 y = hr_patch_point(hit.patch, hit.u, hit.v, HR_PATCH);
        const float other = hr_magnitude(hr_dot(direction, hr_load3(patch_normal, hit.patch)));
        back = hr_aimed_density(outcome, y, -direction, other, HR_AIM);
    }
    hit_density[2 * i + 1] = back;
}

/* Some of the rays of `trace_rows` once more: where they begin, where they lead, how far, and cosines at both ends. */
__kernel void row_rays(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS,
                       __global const uint *number, /* (n,) n_samples row + sample                     */
                       __global float *ray,         /* (n, 9) position, direction, length [m], cosines */
                       const uint n_samples, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = number[i] / n_samples;
    const uint k = number[i] % n_samples;
    const uint row_seed = hr_combine(seed, row);
    const hr_place place = hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed), HR_ELEMENT,
                                           HR_PATCH);
    const float3 d = hr_cosine_direction(place.normal, hr_sample(k, 2, row_seed), hr_sample(k, 3, row_seed));
    const hr_hit hit =
        hr_closest_hit(HR_BVH, hr_offset_origin(place.position, place.normal, scale), d, INFINITY, place.patch);
    __global float *to = ray + 9 * (size_t)i;
    to[0] = place.position.x;
    to[1] = place.position.y;
    to[2] = place.position.z;
    to[3] = d.x;
    to[4] = d.y;
    to[5] = d.z;
    to[6] = hit.patch == HR_NONE ? INFINITY : hit.t;
    to[7] = hr_dot(d, place.normal);
    to[8] = hit.patch == HR_NONE ? 0.0f : hr_magnitude(hr_dot(d, hr_load3(patch_normal, hit.patch)));
}
