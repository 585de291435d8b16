/* Pairs of convex polygons: loading them, and cutting each to what lies in front of the other. */
#ifndef HR_POLYGON_PAIR_H
#define HR_POLYGON_PAIR_H

#include "include/hr_double.h"

#ifndef HR_CORNERS
#error "HR_CORNERS must be set by the host: corners that each polygon has room for"
#endif
/* Cutting by a plane gives a convex polygon one corner more. */
#define HR_CUT_CORNERS (HR_CORNERS + 1)

#define HR_POLYGON_PARAMS                                                                             \
    __global const double *polygon_corner, /* (n_polygons, HR_CORNERS, 3) [m], local frame         */ \
    __global const uint *polygon_count,    /* (n_polygons,) corners that count                     */ \
    __global const double *polygon_normal, /* (n_polygons, 3) unit                                 */ \
    __global const double *polygon_sphere, /* (n_polygons, 4) centroid and radius about it [m]     */ \
    __global const double *polygon_area    /* (n_polygons,) [m^2]                                  */
#define HR_POLYGON polygon_corner, polygon_count, polygon_normal, polygon_sphere, polygon_area

/* Heights below this share of the coordinates are rounding. */
#define HR_FLAT 4.0e-15

HR_FORCE_INLINE double3 hr_sphere_centre(__global const double *polygon_sphere, const uint polygon)
{
    __global const double *row = polygon_sphere + 4 * (size_t)polygon;
    return (double3)(row[0], row[1], row[2]);
}

/* The corners of a polygon moved by -origin and divided by a length. */
inline void hr_load_polygon(const uint polygon, const double3 origin, const double inverse_length, double3 *corner,
                            HR_POLYGON_PARAMS)
{
    for (uint k = 0; k < polygon_count[polygon]; ++k)
        corner[k] = (hr_row_d(polygon_corner, (size_t)polygon * HR_CORNERS + k) - origin) * inverse_length;
}

/* The least height of the polygon's corners above a plane, and the greatest. */
HR_FORCE_INLINE double2 hr_heights(const uint polygon, const double3 point, const double3 n, HR_POLYGON_PARAMS)
{
    double low = INFINITY, high = -INFINITY;
    for (uint k = 0; k < polygon_count[polygon]; ++k) {
        const double h = hr_dot_d(hr_row_d(polygon_corner, (size_t)polygon * HR_CORNERS + k) - point, n);
        low = hr_smaller_d(low, h);
        high = hr_larger_d(high, h);
    }
    return (double2)(low, high);
}

/* Keeps what lies in front of a plane through `point` with unit normal n (Sutherland & Hodgman 1974). Returns the new
   number of corners, 0 when nothing stands out further than `flat`. */
inline uint hr_cut_polygon(double3 *corner, const uint count, const double3 point, const double3 n, const double flat)
{
    double3 whole[HR_CUT_CORNERS];
    double height[HR_CUT_CORNERS];
    double highest = 0.0, lowest = 0.0;
    for (uint k = 0; k < count; ++k) {
        whole[k] = corner[k];
        const double h = hr_dot_d(corner[k] - point, n);
        height[k] = hr_magnitude_d(h) <= flat ? 0.0 : h;
        highest = hr_larger_d(highest, height[k]);
        lowest = hr_smaller_d(lowest, height[k]);
    }
    if (highest <= 0.0)
        return 0;
    if (lowest >= 0.0)
        return count;
    uint kept = 0;
    for (uint k = 0; k < count; ++k) {
        const uint next = k + 1 == count ? 0 : k + 1;
        if (height[k] >= 0.0 && kept < HR_CUT_CORNERS)
            corner[kept++] = whole[k];
        if ((height[k] < 0.0 && height[next] > 0.0) || (height[k] > 0.0 && height[next] < 0.0)) {
            const double t = height[k] / (height[k] - height[next]);
            if (kept < HR_CUT_CORNERS)
                corner[kept++] = whole[k] + t * (whole[next] - whole[k]);
        }
    }
    return kept;
}

/* Both polygons in a frame about the first one's centroid, in units of the pair's extent, each cut to what lies in
   front of the other: all points of one then see all of the other, and A F is that of the parts. Returns the unit of
   length [m]; a count of 0 when they see nothing of each other. */
inline double hr_load_facing(const uint first, const uint second, double3 *a, uint *count_a, double3 *b, uint *count_b,
                             HR_POLYGON_PARAMS)
{
    const double3 centre = hr_sphere_centre(polygon_sphere, first);
    const double3 across = hr_sphere_centre(polygon_sphere, second) - centre;
    const double length =
        sqrt(hr_dot_d(across, across)) + polygon_sphere[4 * (size_t)first + 3] + polygon_sphere[4 * (size_t)second + 3];
    hr_load_polygon(first, centre, 1.0 / length, a, HR_POLYGON);
    hr_load_polygon(second, centre, 1.0 / length, b, HR_POLYGON);
    const double3 na = hr_row_d(polygon_normal, first);
    const double3 nb = hr_row_d(polygon_normal, second);
    const double3 a0 = a[0];
    const double3 b0 = b[0];
    *count_a = hr_cut_polygon(a, polygon_count[first], b0, nb, HR_FLAT);
    *count_b = hr_cut_polygon(b, polygon_count[second], a0, na, HR_FLAT);
    if (*count_a < 3 || *count_b < 3)
        *count_a = *count_b = 0;
    return length;
}

#endif
