/* Exchange of two polygons as a double sum over points on their areas:
   A F = sum over x in a, y in b of w_x w_y cos cos / (pi r^2). Four points of b at a time. */
#ifndef HR_AREA_PAIR_H
#define HR_AREA_PAIR_H

#include "include/hr_double.h"

/* Relative error that rounding leaves in sums of up to some hundred terms. */
#define HR_AREA_ROUNDING 1.0e-14

/* Points of one polygon: n_points each of x, y, z [m] and weight [m^2]; n_points is a multiple of 4. */
HR_FORCE_INLINE double hr_area_exchange(const double3 na, const double3 nb, __global const double *a,
                                        __global const double *b, const uint n_points)
{
    __global const double4 *bx = (__global const double4 *)b;
    __global const double4 *by = (__global const double4 *)(b + n_points);
    __global const double4 *bz = (__global const double4 *)(b + 2 * n_points);
    __global const double4 *bw = (__global const double4 *)(b + 3 * n_points);
    double4 sum = (double4)(0.0);
    for (uint k = 0; k < n_points; ++k) {
        const double weight = a[3 * n_points + k];
        if (weight == 0.0)
            continue;
        for (uint l = 0; l < n_points / 4; ++l) {
            const double4 x = bx[l] - a[k];
            const double4 y = by[l] - a[n_points + k];
            const double4 z = bz[l] - a[2 * n_points + k];
            const double4 r2 = x * x + y * y + z * z;
            const double4 leaving = na.x * x + na.y * y + na.z * z;
            const double4 arriving = nb.x * x + nb.y * y + nb.z * z;
            sum -= weight * bw[l] * leaving * arriving / (r2 * r2);
        }
    }
    return (sum.x + sum.y + sum.z + sum.w) * (1.0 / HR_PI_D);
}

/* Relative error of `order` Gauss points a direction on one polygon: the remainder for 1/r^4, whose pole lies straight
   ahead at the distance that is left between this polygon's centre and the other one's sphere; constants from the
   remainder of Gauss quadrature. ratio: radius over that distance. The height over the other plane, linear, takes one
   degree of exactness where it varies much over the polygon. slope: radius over the height of the centre. */
HR_FORCE_INLINE double hr_area_error(const uint order, const double ratio, const double slope)
{
    const double r2 = ratio * ratio;
    const double odd = ratio * hr_larger_d(ratio, hr_smaller_d(slope, 2.0));
    if (order == 1)
        return 3.4 * odd;
    if (order == 2)
        return 3.2 * odd * r2;
    if (order == 3)
        return 2.0 * odd * r2 * r2;
    return odd * r2 * r2 * r2;
}

#endif
