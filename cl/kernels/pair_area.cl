/* Exchange of polygon pairs that are far from each other, by Gauss points on both; the rest is left open. */
#include "include/hr_area_pair.h"
#include "include/hr_polygon_pair.h"

/* The lowest order from 1 to 4 that the tolerance allows. */
__kernel void choose_orders(HR_POLYGON_PARAMS,
                            __global const uint *first,  /* (n_items,)                                          */
                            __global const uint *second, /* (n_items,)                                          */
                            const double tolerance,      /* relative                                            */
                            __global uchar *order_taken, /* (n_items,) 0: nothing is seen, 1-4, 255: left open  */
                            __global float *relative,    /* (n_items,) error that the order leaves              */
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
    order_taken[i] = 0;
    relative[i] = 0.0f;
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
    double error = INFINITY;
    uint order = 0;
    while (error > tolerance && ++order <= 4)
        error = hr_area_error(order, ratio_p, rp / height_p) + hr_area_error(order, ratio_q, rq / height_q);
    if (order > 4)
        return;
    order_taken[i] = (uchar)order;
    relative[i] = (float)(error * 1.000001 + HR_AREA_ROUNDING);
}

/* The double sum, for pairs with an order from 1 to 4. */
__kernel void area_exchange(__global const double *polygon_normal, /* (n_polygons, 3) unit                         */
                            __global const uint *first,            /* (n_items,)                                   */
                            __global const uint *second,           /* (n_items,)                                   */
                            __global const uchar *order_taken,     /* (n_items,)                                   */
                            __global const double *rule_point,     /* for each order (n_polygons, 4, n_points)     */
                            __global const ulong *rule_start,      /* (4,) where an order starts, in doubles       */
                            __global const uint *rule_length,      /* (4,) points of an order                      */
                            __global double *exchange,             /* (n_items,) A F [m^2], 0 for other pairs      */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    exchange[i] = 0.0;
    const uint order = order_taken[i];
    if (order == 0 || order > 4)
        return;
    const uint p = first[i], q = second[i];
    const uint n_points = rule_length[order - 1];
    __global const double *rule = rule_point + rule_start[order - 1];
    exchange[i] = hr_area_exchange(hr_row_d(polygon_normal, p), hr_row_d(polygon_normal, q),
                                   rule + (size_t)p * 4 * n_points, rule + (size_t)q * 4 * n_points, n_points);
}
