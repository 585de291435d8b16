/* How much of the exchange of polygon pairs other polygons leave: proved where possible, else sampled. */
#include "include/hr_pair_shaft.h"

/* Lists of occluders up to this length are made once for a pair; longer ones are gone through at each sample. */
#define HR_LISTED 64

/* Sides of 32 occluders from one polygon. */
__kernel void occluder_sides(HR_POLYGON_PARAMS,
                             const uint first_occluder, const uint n_occluders, const uint n_words,
                             __global uint *side_front, /* (n_seeing, n_words) see HR_SIDES_PARAMS */
                             __global uint *side_above, /* (n_seeing, n_words)                     */
                             __global uint *side_below, /* (n_seeing, n_words)                     */
                             const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = i / n_words, word = i % n_words;
    const double3 n = hr_row_d(polygon_normal, p);
    const double3 at = hr_row_d(polygon_corner, (size_t)p * HR_CORNERS);
    uint front = 0u, above = 0u, below = 0u;
    for (uint k = 0; k < 32u && 32u * word + k < n_occluders; ++k) {
        const uint occluder = first_occluder + 32u * word + k;
        const double3 place = hr_row_d(polygon_corner, (size_t)occluder * HR_CORNERS);
        const double3 off = place - at;
        const double flat = HR_ON_OCCLUDER * (sqrt(hr_dot_d(off, off)) + polygon_sphere[4 * (size_t)p + 3] +
                                              polygon_sphere[4 * (size_t)occluder + 3]);
        const double2 own = hr_heights(occluder, at, n, HR_POLYGON);
        const double2 seen = hr_heights(p, place, hr_row_d(polygon_normal, occluder), HR_POLYGON);
        front |= own.y > flat ? 1u << k : 0u;
        above |= seen.x >= -flat ? 1u << k : 0u;
        below |= seen.y <= flat ? 1u << k : 0u;
    }
    side_front[i] = front;
    side_above[i] = above;
    side_below[i] = below;
}

/* 1 where something may stand between a pair; 0 is a proof that nothing does. */
__kernel void find_doubtful(HR_POLYGON_PARAMS, HR_SIDES_PARAMS,
                            __global const uint *first,  /* (n_items,) */
                            __global const uint *second, /* (n_items,) */
                            const uint first_occluder,
                            __global uchar *is_doubtful, /* (n_items,) */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    uchar found = 0;
    for (uint word = 0; word < n_words && !found; ++word)
        found = hr_candidates(first[i], second[i], word, first_occluder, HR_SIDES, HR_POLYGON) ? 1 : 0;
    is_doubtful[i] = found;
}

/* Sums of the kernel cos cos / r^4 over samples, all of them and those in sight of each other; one work-item takes
   one replicate of one pair. */
__kernel void sample_visibility(HR_POLYGON_PARAMS, HR_SIDES_PARAMS,
                                __global const uint *first,  /* (n_pairs,) */
                                __global const uint *second, /* (n_pairs,) */
                                const uint first_occluder, const uint n_occluders, const uint n_replicates,
                                const uint n_samples, const uint seed,
                                __global double *total,   /* (n_pairs, n_replicates) [m^-2] */
                                __global double *visible, /* (n_pairs, n_replicates) [m^-2] */
                                const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i / n_replicates], q = second[i / n_replicates];
    uint listed[HR_LISTED];
    uint count = 0;
    for (uint word = 0; word < n_words; ++word) {
        const uint bits = hr_candidates(p, q, word, first_occluder, HR_SIDES, HR_POLYGON);
        for (uint k = 0; k < 32u; ++k) {
            if (!(bits & (1u << k)))
                continue;
            if (count < HR_LISTED)
                listed[count] = first_occluder + 32u * word + k;
            ++count;
        }
    }
    const int is_listed = count <= HR_LISTED;
    const uint n_tried = is_listed ? count : n_occluders;
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    const uint key = hr_pair_seed(seed, p, q, i % n_replicates, polygon_sphere);
    double sum = 0.0, seen = 0.0;
    for (uint k = 0; k < n_samples; ++k) {
        const double3 x = hr_point_on_polygon(p, hr_sample_pair(k, 0, key, 1), HR_POLYGON);
        const double3 d = hr_point_on_polygon(q, hr_sample_pair(k, 2, key, 1), HR_POLYGON) - x;
        const double r2 = hr_dot_d(d, d);
        const double leaving = hr_dot_d(np, d), arriving = -hr_dot_d(nq, d);
        if (!(leaving > 0.0 && arriving > 0.0))
            continue;
        const double weight = leaving * arriving / (r2 * r2);
        int blocked = 0;
        for (uint l = 0; l < n_tried && !blocked; ++l)
            blocked = hr_segment_blocked(x, d, HR_ON_OCCLUDER * sqrt(r2), is_listed ? listed[l] : first_occluder + l,
                                         HR_POLYGON);
        sum += weight;
        seen += blocked ? 0.0 : weight;
    }
    total[i] = sum;
    visible[i] = seen;
}
