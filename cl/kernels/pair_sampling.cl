/* Exchange of polygon pairs by random points on both, and by random rays from one. */
#include "include/hr_pair_sampling.h"

/* One work-item takes the samples of one replicate of one pair: x on the first polygon, y drawn evenly on the second one
   and, unless they are far from each other, where a cosine-distributed ray from x meets it. Weighed with the balance
   heuristic (Veach & Guibas 1995) neither counts more than 1, however near the polygons are. */
__kernel void sample_exchange(HR_POLYGON_PARAMS,
                              __global const uint *first,  /* (n_pairs,)                                       */
                              __global const uint *second, /* (n_pairs,)                                       */
                              const uint n_replicates, const uint n_samples,
                              const uint sequence,       /* 1: Sobol points, scrambled anew in each replicate  */
                              const uint seed,
                              __global double *exchange, /* (n_pairs, n_replicates) A F [m^2]                  */
                              const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i / n_replicates], q = second[i / n_replicates];
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    const float3 n = (float3)((float)np.x, (float)np.y, (float)np.z);
    const uint key = hr_pair_seed(seed, p, q, i % n_replicates, polygon_sphere);
    const double area = polygon_area[q];
    const double3 on_q = hr_row_d(polygon_corner, (size_t)q * HR_CORNERS);
    const double3 across = hr_sphere_centre(polygon_sphere, q) - hr_sphere_centre(polygon_sphere, p);
    const double reach = 2.0 * (polygon_sphere[4 * (size_t)p + 3] + polygon_sphere[4 * (size_t)q + 3]);
    const int is_near = hr_dot_d(across, across) < reach * reach;
    double sum = 0.0;
    for (uint k = 0; k < n_samples; ++k) {
        const double3 x = hr_point_on_polygon(p, hr_sample_pair(k, 0, key, sequence), HR_POLYGON);
        const double2 place = hr_sample_pair(k, 2, key, sequence);
        const double even = hr_even_share(np, hr_point_on_polygon(q, place, HR_POLYGON) - x, nq, area);
        sum += is_near ? even / (1.0 + even) : even;
        if (!is_near)
            continue;
        const float3 towards = hr_cosine_direction(n, (float)place.x, (float)place.y);
        const double3 d = (double3)(towards.x, towards.y, towards.z);
        if (!hr_ray_meets(x, d, q, HR_POLYGON))
            continue;
        const double met = hr_even_share(np, hr_dot_d(on_q - x, nq) / hr_dot_d(d, nq) * d, nq, area);
        sum += met / (1.0 + met);
    }
    exchange[i] = sum * polygon_area[p] / n_samples;
}

/* Cosine-distributed rays from uniform points: the share that meets the other polygon is the form factor. */
__kernel void trace_exchange(HR_POLYGON_PARAMS,
                             __global const uint *first,  /* (n_pairs,)                                       */
                             __global const uint *second, /* (n_pairs,)                                       */
                             const uint n_replicates, const uint n_samples,
                             const uint sequence,       /* 1: Sobol points, scrambled anew in each replicate  */
                             const uint seed,
                             __global double *exchange, /* (n_pairs, n_replicates) A F [m^2]                  */
                             const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i / n_replicates], q = second[i / n_replicates];
    const double3 np = hr_row_d(polygon_normal, p);
    const float3 n = (float3)((float)np.x, (float)np.y, (float)np.z);
    const uint key = hr_pair_seed(seed, p, q, i % n_replicates, polygon_sphere);
    uint met = 0;
    for (uint k = 0; k < n_samples; ++k) {
        const double3 x = hr_point_on_polygon(p, hr_sample_pair(k, 0, key, sequence), HR_POLYGON);
        const double2 turn = hr_sample_pair(k, 2, key, sequence);
        const float3 d = hr_cosine_direction(n, (float)turn.x, (float)turn.y);
        met += (uint)hr_ray_meets(x, (double3)(d.x, d.y, d.z), q, HR_POLYGON);
    }
    exchange[i] = polygon_area[p] * met / n_samples;
}
