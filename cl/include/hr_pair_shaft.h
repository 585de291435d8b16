/* Which polygons may stand between two others: conservative tests of the hull of the pair. */
#ifndef HR_PAIR_SHAFT_H
#define HR_PAIR_SHAFT_H

#include "include/hr_pair_sampling.h"

#define HR_SIDES_PARAMS                                                                                       \
    __global const uint *side_front, /* (n_seeing, n_words) bit: occluder reaches in front of the polygon  */ \
    __global const uint *side_above, /* (n_seeing, n_words) bit: polygon wholly on the occluder's front    */ \
    __global const uint *side_below, /* (n_seeing, n_words) bit: polygon wholly on the occluder's back     */ \
    const uint n_words
#define HR_SIDES side_front, side_above, side_below, n_words

/* Heights over an occluder below this share of the distances involved are rounding: what touches it, it does not hide. */
#define HR_ON_OCCLUDER 1.0e-12

/* Of 32 occluders, those that may come between p and q: they reach in front of both; the plane of none of them has
   both on one side, which would part it from their hull; and their spheres meet the hull of the pair's spheres. */
inline uint hr_candidates(const uint p, const uint q, const uint word, const uint first_occluder, HR_SIDES_PARAMS,
                          HR_POLYGON_PARAMS)
{
    const size_t row_p = (size_t)p * n_words + word, row_q = (size_t)q * n_words + word;
    uint bits = side_front[row_p] & side_front[row_q];
    bits &= ~(side_above[row_p] & side_above[row_q]);
    bits &= ~(side_below[row_p] & side_below[row_q]);
    if (bits == 0u)
        return 0u;
    const double3 start = hr_sphere_centre(polygon_sphere, p);
    const double3 step = hr_sphere_centre(polygon_sphere, q) - start;
    const double widest = hr_larger_d(polygon_sphere[4 * (size_t)p + 3], polygon_sphere[4 * (size_t)q + 3]);
    for (uint k = 0; k < 32u; ++k) {
        if (!(bits & (1u << k)))
            continue;
        const uint occluder = first_occluder + 32u * word + k;
        const double reach = (widest + polygon_sphere[4 * (size_t)occluder + 3]) * (1.0 + 1.0e-12);
        if (hr_segment_distance2(hr_sphere_centre(polygon_sphere, occluder), start, step) > reach * reach)
            bits &= ~(1u << k);
    }
    return bits;
}

#endif
