/* Exchange of polygon pairs from hemicubes over points of one; nothing stands between the pair. */
#include "include/hr_pair_hemicube.h"
#include "include/hr_pair_sampling.h"

/* One work-item adds up the hemicubes of one pair, each turned by a random angle. */
__kernel void hemicube_exchange(HR_POLYGON_PARAMS,
                                __global const uint *first,        /* (n_pairs,) receivers                       */
                                __global const uint *second,       /* (n_pairs,)                                 */
                                __global const double *rule_point, /* (n_rows, 4, n_points) x, y, z, weight      */
                                __global const uint *rule_row,     /* (n_pairs,) row of the receiver                 */
                                __global const float *pixel,       /* (1.5 resolution^2,) form factor of each    */
                                const uint n_points, const uint resolution, const uint n_turns, const uint seed,
                                __global double *exchange,         /* (n_pairs, n_turns) A F [m^2]               */
                                const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i / n_turns], q = second[i / n_turns];
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    __global const double *rule = rule_point + (size_t)rule_row[i / n_turns] * 4 * n_points;
    double3 corner[HR_CORNERS];
    const uint key = hr_pair_seed(seed, p, q, i % n_turns, polygon_sphere);
    double sum = 0.0;
    for (uint k = 0; k < n_points; ++k) {
        const double weight = rule[3 * n_points + k];
        const double3 x = (double3)(rule[k], rule[n_points + k], rule[2 * n_points + k]);
        if (weight == 0.0 || hr_dot_d(x - hr_row_d(polygon_corner, (size_t)q * HR_CORNERS), nq) <= 0.0)
            continue;
        hr_load_polygon(q, x, 1.0, corner, HR_POLYGON);
        const float turn = hr_unit_float(hr_combine(key, k));
        sum += weight * hr_covered_pixels(np, 2.0 * HR_PI_D * turn, corner, polygon_count[q], pixel, resolution);
    }
    exchange[i] = sum;
}
