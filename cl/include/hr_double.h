/* Vectors in double precision, inlined without fail (see hr_types.h). */
#ifndef HR_DOUBLE_H
#define HR_DOUBLE_H

#pragma OPENCL EXTENSION cl_khr_fp64 : enable

#include "include/hr_types.h"

#define HR_PI_D 3.14159265358979323846
#define HR_EPSILON_D 0x1p-52

HR_FORCE_INLINE double hr_dot_d(const double3 a, const double3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

HR_FORCE_INLINE double3 hr_cross_d(const double3 a, const double3 b)
{
    return (double3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

HR_FORCE_INLINE double hr_larger_d(const double a, const double b)
{
    return a > b ? a : b;
}

HR_FORCE_INLINE double hr_smaller_d(const double a, const double b)
{
    return a < b ? a : b;
}

HR_FORCE_INLINE double hr_magnitude_d(const double x)
{
    return x < 0.0 ? -x : x;
}

/* Three packed coordinates of a row of (n, 3). */
HR_FORCE_INLINE double3 hr_row_d(__global const double *rows, const size_t i)
{
    __global const double *row = rows + 3 * i;
    return (double3)(row[0], row[1], row[2]);
}

#endif
