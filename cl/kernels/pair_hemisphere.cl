/* Exchange of polygon pairs from the projections of one on hemispheres over points of the other. */
#include "include/hr_lambert.h"
#include "include/hr_polygon_pair.h"

__kernel void hemisphere_exchange(HR_POLYGON_PARAMS,
                                  __global const uint *first,        /* (n_items,) receivers                      */
                                  __global const uint *second,       /* (n_items,)                                */
                                  __global const double *rule_point, /* (n_rows, 4, n_points) x, y, z, weight     */
                                  __global const uint *rule_row,     /* (n_items,) row of the receiver                */
                                  const uint n_points,
                                  const uint halvings,       /* arcs become 2^halvings chords; HR_EXACT_ARC */
                                  __global double *exchange, /* (n_items,) A F [m^2]                        */
                                  const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i], q = second[i];
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    __global const double *rule = rule_point + (size_t)rule_row[i] * 4 * n_points;
    const uint count = polygon_count[q];
    const double flat = HR_FLAT * (polygon_sphere[4 * (size_t)p + 3] + polygon_sphere[4 * (size_t)q + 3]);
    double3 corner[HR_CORNERS];
    double sum = 0.0;
    for (uint k = 0; k < n_points; ++k) {
        const double weight = rule[3 * n_points + k];
        const double3 x = (double3)(rule[k], rule[n_points + k], rule[2 * n_points + k]);
        if (weight == 0.0 || hr_dot_d(x - hr_row_d(polygon_corner, (size_t)q * HR_CORNERS), nq) <= flat)
            continue;
        hr_load_polygon(q, x, 1.0, corner, HR_POLYGON);
        sum += weight * hr_lambert(np, corner, count, halvings);
    }
    exchange[i] = sum;
}
