/* Exchange of polygon pairs from sizes, angles and the distance of centroids alone. */
#include "include/hr_double.h"

__kernel void point_exchange(__global const double *polygon_normal, /* (n_polygons, 3) unit                      */
                             __global const double *polygon_sphere, /* (n_polygons, 4) centroid and radius [m]   */
                             __global const double *polygon_area,   /* (n_polygons,) [m^2]                       */
                             __global const uint *first,            /* (n_items,)                                */
                             __global const uint *second,           /* (n_items,)                                */
                             const uint disks,                      /* 1: treat both as disks of their area      */
                             __global double *exchange,             /* (n_items,) A F [m^2]                      */
                             const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i], q = second[i];
    __global const double *cp = polygon_sphere + 4 * (size_t)p;
    __global const double *cq = polygon_sphere + 4 * (size_t)q;
    const double3 d = (double3)(cq[0] - cp[0], cq[1] - cp[1], cq[2] - cp[2]);
    const double r2 = hr_dot_d(d, d);
    const double leaving = hr_larger_d(hr_dot_d(hr_row_d(polygon_normal, p), d), 0.0);
    const double arriving = hr_larger_d(-hr_dot_d(hr_row_d(polygon_normal, q), d), 0.0);
    const double areas = polygon_area[p] + polygon_area[q];
    const double spread = HR_PI_D * r2 + (disks ? areas : 0.0);
    exchange[i] = r2 > 0.0 ? polygon_area[p] * polygon_area[q] * leaving * arriving / (r2 * spread) : 0.0;
}
