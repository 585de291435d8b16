/* Pixels of a hemicube that one convex polygon covers. */
#ifndef HR_PAIR_HEMICUBE_H
#define HR_PAIR_HEMICUBE_H

#include "include/hr_hemicube.h"
#include "include/hr_polygon_pair.h"

/* Share of the hemisphere over a point, weighted with the cosine, that a convex polygon in front of it covers: sum of
   the pixels whose centres look at it. corner: from the point. normal, angle: as in hr_hemicube_face. */
inline double hr_covered_pixels(const double3 normal, const double angle, const double3 *corner, const uint count,
                                __global const float *weight, const uint resolution)
{
    double sum = 0.0;
    for (uint face = 0; face < HR_HEMICUBE_FACES; ++face) {
        const hr_face axes = hr_hemicube_face(normal, angle, face);
        const uint rows = face == 0 ? resolution : resolution / 2;
        __global const float *face_weight = weight + (face == 0 ? 0 : (size_t)resolution * resolution);
        for (uint row = 0; row < rows; ++row) {
            const double y = (2.0 * row + 1.0) / resolution - (face == 0 ? 1.0 : 0.0);
            double low = -1.0, high = 1.0;
            for (uint k = 0; k < count && low <= high; ++k) {
                const double3 r = corner[k];
                const double3 across = hr_cross_d(corner[k + 1 == count ? 0 : k + 1] - r, r);
                hr_narrow(hr_in_frame(across, axes), y, &low, &high);
            }
            const double first = ceil(0.5 * ((low + 1.0) * resolution - 1.0));
            const double last = floor(0.5 * ((high + 1.0) * resolution - 1.0));
            const uint end = last < 0.0 ? 0 : (uint)hr_smaller_d(last + 1.0, resolution);
            for (uint x = first > 0.0 ? (uint)hr_smaller_d(first, resolution) : 0; x < end; ++x)
                sum += face_weight[row * resolution + x];
        }
    }
    return sum;
}

#endif
