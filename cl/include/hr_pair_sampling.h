/* Random points on polygons and what lies between them. */
#ifndef HR_PAIR_SAMPLING_H
#define HR_PAIR_SAMPLING_H

#include "include/hr_polygon_pair.h"
#include "include/hr_sampling.h"

/* Two numbers in [0, 1) of sample `index` (below 2^24): coordinates `dimension` and the next of a scrambled Sobol
   sequence, or of none that repeats. */
HR_FORCE_INLINE double2 hr_sample_pair(const uint index, const uint dimension, const uint seed, const uint sequence)
{
    if (sequence)
        return (double2)(hr_sample(index, dimension, seed), hr_sample(index, dimension + 1, seed));
    const uint key = hr_combine(hr_combine(seed, index), dimension);
    return (double2)(hr_unit_float(key), hr_unit_float(hr_hash(key ^ 0x85ebca6bu)));
}

HR_FORCE_INLINE uint hr_place_bits(__global const double *polygon_sphere, const uint polygon)
{
    __global const double *row = polygon_sphere + 4 * (size_t)polygon;
    const uint xy = hr_combine(as_uint((float)row[0]), as_uint((float)row[1]));
    return hr_combine(xy, as_uint((float)row[2]));
}

/* Seed of one pair and replicate. It follows from where the polygons are, not from their numbers, so that a pair gives
   the same however it is listed, while errors of different pairs have nothing to do with each other. */
HR_FORCE_INLINE uint hr_pair_seed(const uint seed, const uint p, const uint q, const uint replicate,
                                  __global const double *polygon_sphere)
{
    const uint place = hr_combine(hr_place_bits(polygon_sphere, p), hr_place_bits(polygon_sphere, q));
    return hr_combine(hr_combine(seed, place), replicate);
}

/* Point of a convex polygon, uniform in area: a triangle of the fan about the first corner by u, whose remainder is
   used again; square-root map inside it. */
inline double3 hr_point_on_polygon(const uint polygon, const double2 u, HR_POLYGON_PARAMS)
{
    const size_t row = (size_t)polygon * HR_CORNERS;
    const double3 origin = hr_row_d(polygon_corner, row);
    const double3 n = hr_row_d(polygon_normal, polygon);
    double left = u.x * 2.0 * polygon_area[polygon];
    double3 one = hr_row_d(polygon_corner, row + 1) - origin, other = one;
    double twice_area = 1.0;
    for (uint k = 2; k < polygon_count[polygon]; ++k) {
        one = hr_row_d(polygon_corner, row + k - 1) - origin;
        other = hr_row_d(polygon_corner, row + k) - origin;
        twice_area = hr_dot_d(hr_cross_d(one, other), n);
        if (left < twice_area)
            break;
        left -= twice_area;
    }
    const double share = twice_area > 0.0 ? hr_smaller_d(hr_larger_d(left, 0.0) / twice_area, 1.0) : 0.0;
    const double far = sqrt(share);
    return origin + far * (one + u.y * (other - one));
}

/* Distance of a point from a segment, squared. */
HR_FORCE_INLINE double hr_segment_distance2(const double3 point, const double3 start, const double3 step)
{
    const double length2 = hr_dot_d(step, step);
    double t = length2 > 0.0 ? hr_dot_d(point - start, step) / length2 : 0.0;
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    const double3 off = start + t * step - point;
    return hr_dot_d(off, off);
}

/* 1 when the segment from x along d goes through a convex polygon at 0 < t < 1; its ends do not count. */
inline int hr_segment_blocked(const double3 x, const double3 d, const double flat, const uint polygon,
                              HR_POLYGON_PARAMS)
{
    const size_t row = (size_t)polygon * HR_CORNERS;
    const double3 n = hr_row_d(polygon_normal, polygon);
    const double start = hr_dot_d(x - hr_row_d(polygon_corner, row), n);
    const double end = start + hr_dot_d(d, n);
    if (!((start > flat && end < -flat) || (start < -flat && end > flat)))
        return 0;
    const double3 at = x + (start / (start - end)) * d;
    const uint count = polygon_count[polygon];
    double3 a = hr_row_d(polygon_corner, row + count - 1);
    for (uint k = 0; k < count; ++k) {
        const double3 b = hr_row_d(polygon_corner, row + k);
        if (hr_dot_d(hr_cross_d(b - a, at - a), n) < 0.0)
            return 0;
        a = b;
    }
    return 1;
}

/* 1 when a ray from x with direction d meets the front of a convex polygon. */
inline int hr_ray_meets(const double3 x, const double3 d, const uint polygon, HR_POLYGON_PARAMS)
{
    const size_t row = (size_t)polygon * HR_CORNERS;
    const double3 n = hr_row_d(polygon_normal, polygon);
    const uint count = polygon_count[polygon];
    double3 a = hr_row_d(polygon_corner, row + count - 1) - x;
    if (hr_dot_d(n, a) >= 0.0 || hr_dot_d(n, d) >= 0.0)
        return 0;
    for (uint k = 0; k < count; ++k) {
        const double3 b = hr_row_d(polygon_corner, row + k) - x;
        if (hr_dot_d(hr_cross_d(a, b - a), d) > 0.0)
            return 0;
        a = b;
    }
    return 1;
}

/* Share of all that leaves a point x with unit normal n and that arrives at a polygon of area b around the place d away,
   as seen from there: b cos cos / (pi r^2). */
HR_FORCE_INLINE double hr_even_share(const double3 n, const double3 d, const double3 other, const double b)
{
    const double r2 = hr_dot_d(d, d);
    const double leaving = hr_dot_d(n, d), arriving = -hr_dot_d(other, d);
    return leaving > 0.0 && arriving > 0.0 ? b * leaving * arriving / (HR_PI_D * r2 * r2) : 0.0;
}

#endif
