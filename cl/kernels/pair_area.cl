/* Exchange of polygon pairs that are far from each other, by Gauss points on both; the rest is left open. */
#include "include/hr_area_pair.h"
#include "include/hr_polygon_pair.h"

/* Orders 1 to 4, the lowest that the tolerance allows. */
__kernel void area_exchange(HR_POLYGON_PARAMS,
                            __global const uint *first,        /* (n_items,)                                      */
                            __global const uint *second,       /* (n_items,)                                      */
                            __global const double *rule_point, /* for each order (n_polygons, 4, n_points)        */
                            __global const uint *rule_start,   /* (4,) where an order starts, in doubles          */
                            __global const uint *rule_length,  /* (4,) points of an order                         */
                            const double tolerance,            /* relative                                        */
                            __global double *exchange,         /* (n_items,) A F [m^2]                            */
                            __global double *error,            /* (n_items,) [m^2]                                */
                            __global uchar *order_taken,       /* (n_items,) 0: nothing seen, 1-4, 255: left open */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i], q = second[i];
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    const double3 cp = hr_sphere_centre(polygon_sphere, p), cq = hr_sphere_centre(polygon_sphere, q);
    const double rp = polygon_sphere[4 * (size_t)p + 3], rq = polygon_sphere[4 * (size_t)q + 3];
    const double3 across = cq - cp;
    const double distance = sqrt(hr_dot_d(across, across));
    const double flat = HR_FLAT * (distance + rp + rq);
    exchange[i] = 0.0;
    error[i] = 0.0;
    order_taken[i] = 0;
    /* Centroids further behind a plane than the radius: nothing to see; further in front: all is seen. */
    const double height_q = hr_dot_d(across, np), height_p = -hr_dot_d(across, nq);
    double2 of_q = (double2)(height_q), of_p = (double2)(height_p);
    if (of_q.x < -rq || of_p.x < -rp)
        return;
    if (of_q.x <= rq)
        of_q = hr_heights(q, cp, np, HR_POLYGON);
    if (of_p.x <= rp)
        of_p = hr_heights(p, cq, nq, HR_POLYGON);
    if (of_q.y <= flat || of_p.y <= flat)
        return;
    order_taken[i] = 255;
    if (of_q.x < -flat || of_p.x < -flat || distance <= rp + rq)
        return;
    const double ratio_p = rp / (distance - rq), ratio_q = rq / (distance - rp);
    double relative = INFINITY;
    uint order = 0;
    while (relative > tolerance && ++order <= 4)
        relative = hr_area_error(order, ratio_p, rp / height_p) + hr_area_error(order, ratio_q, rq / height_q);
    if (order > 4)
        return;
    const uint n_points = rule_length[order - 1];
    __global const double *rule = rule_point + rule_start[order - 1];
    const double value =
        hr_area_exchange(np, nq, rule + (size_t)p * 4 * n_points, rule + (size_t)q * 4 * n_points, n_points);
    exchange[i] = value;
    error[i] = (relative + HR_AREA_ROUNDING) * value;
    order_taken[i] = (uchar)order;
}
