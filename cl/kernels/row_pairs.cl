/* How much of the exchange between pairs of row elements is open. */
#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_outcomes.h"

/* Samples beyond the wanted ones, in multiples of them, that are drawn while all lay behind a horizon. */
#define HR_PATIENCE 4u

/* The k-th origin of the exchange rays of a row. */
HR_FORCE_INLINE hr_place hr_origin_on_row(const uint row, const uint k, const uint seed, HR_ELEMENT_PARAMS,
                                          HR_PATCH_PARAMS)
{
    const uint row_seed = hr_combine(seed, row);
    return hr_place_on_row(row, hr_sample(k, 0, row_seed), hr_sample(k, 1, row_seed), HR_ELEMENT, HR_PATCH);
}

/* Sums of w = cos cos / r^4 over pairs of points, all of them and those in sight of each other, and of w^2 likewise.
   The points are the origins of the rows' own exchange rays; those that lie inside a solid see nothing. Which go
   together is drawn at random: points of one number would pair the same parts of both elements again and again. */
__kernel void sample_row_pairs(HR_BVH_PARAMS, HR_PATCH_PARAMS, HR_ELEMENT_PARAMS,
                               __global const uint *hit_row,      /* (n_rows, n_rays), from trace_rows       */
                               __global const uint *pair_first,   /* (n_items,) rows                         */
                               __global const uint *pair_second,  /* (n_items,)                              */
                               __global const uint *pair_samples, /* (n_items,) wanted samples               */
                               __global float *sums,              /* (n_items, 4) w, open w, w^2, open w^2   */
                               const uint n_rays, const uint occlusion, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = pair_first[i], q = pair_second[i];
    const uint key = hr_combine(hr_combine(hr_hash(seed), p), q);
    const uint wanted = pair_samples[i];
    float all = 0.0f, open = 0.0f, all2 = 0.0f, open2 = 0.0f;
    for (uint k = 0; k < wanted || (all == 0.0f && k < HR_PATIENCE * wanted); ++k) {
        const uint kp = (key + k) % n_rays;
        const uint kq = hr_combine(key, k) % n_rays;
        const hr_place x = hr_origin_on_row(p, kp, seed, HR_ELEMENT, HR_PATCH);
        const hr_place y = hr_origin_on_row(q, kq, seed, HR_ELEMENT, HR_PATCH);
        const float3 d = y.position - x.position;
        const float leaving = hr_dot(x.normal, d), arriving = -hr_dot(y.normal, d);
        if (!(leaving > 0.0f && arriving > 0.0f))
            continue;
        const float r2 = hr_dot(d, d);
        const float weight = leaving / r2 * (arriving / r2);
        all += weight;
        all2 += weight * weight;
        if (hit_row[p * n_rays + kp] == HR_COVERED || hit_row[q * n_rays + kq] == HR_COVERED)
            continue;
        const float3 origin = hr_offset_origin(x.position, x.normal, scale);
        if (occlusion && hr_any_hit(HR_BVH, origin, y.position - origin, 1.0f, x.patch, y.patch))
            continue;
        open += weight;
        open2 += weight * weight;
    }
    sums[4 * (size_t)i] = all;
    sums[4 * (size_t)i + 1] = open;
    sums[4 * (size_t)i + 2] = all2;
    sums[4 * (size_t)i + 3] = open2;
}
