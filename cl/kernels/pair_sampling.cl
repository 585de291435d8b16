/* Exchange of polygon pairs by random points on both, and by random rays from one. */
#include "include/hr_pair_sampling.h"

/* One work-item takes the samples of one replicate of one pair. Where the polygons are nearer to each other than a disk
   that holds three points of all replicates, there the kernel may be large and yet unseen: up to the area of such
   places is missing, whatever the samples say. */
__kernel void sample_exchange(HR_POLYGON_PARAMS,
                              __global const uint *first,  /* (n_pairs,)                                       */
                              __global const uint *second, /* (n_pairs,)                                       */
                              const uint n_replicates, const uint n_samples,
                              const uint sequence,       /* 1: Sobol points, scrambled anew in each replicate  */
                              const uint seed,
                              __global double *exchange, /* (n_pairs, n_replicates) A F [m^2]                  */
                              __global double *unseen,   /* (n_pairs, n_replicates) [m^2], see below           */
                              const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = first[i / n_replicates], q = second[i / n_replicates];
    const double3 np = hr_row_d(polygon_normal, p), nq = hr_row_d(polygon_normal, q);
    const uint key = hr_pair_seed(seed, p, q, i % n_replicates, polygon_sphere);
    const double reach2 = 3.0 * polygon_area[q] / (HR_PI_D * n_replicates * n_samples);
    double sum = 0.0;
    uint near = 0;
    for (uint k = 0; k < n_samples; ++k) {
        const double3 x = hr_point_on_polygon(p, hr_sample_pair(k, 0, key, sequence), HR_POLYGON);
        const double3 y = hr_point_on_polygon(q, hr_sample_pair(k, 2, key, sequence), HR_POLYGON);
        near += hr_polygon_distance2(x, q, HR_POLYGON) < reach2 ? 1u : 0u;
        const double3 d = y - x;
        const double r2 = hr_dot_d(d, d);
        const double leaving = hr_dot_d(np, d), arriving = -hr_dot_d(nq, d);
        if (leaving > 0.0 && arriving > 0.0)
            sum += leaving * arriving / (r2 * r2);
    }
    exchange[i] = sum * polygon_area[p] * polygon_area[q] / (HR_PI_D * n_samples);
    unseen[i] = polygon_area[p] * near / n_samples;
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
