/* Rays that are aimed at spots, balls that much of the light passes, and how dense that makes rays in a direction. */
#ifndef HR_AIMS_H
#define HR_AIMS_H

#include "include/hr_sampling.h"

/* A row sends a share of its rays at each spot, the rest by the cosine law. */
#define HR_AIM_PARAMS                                                              \
    __global const float *aim_spot, /* (n_spots, 4) centre and radius [m]       */ \
    __global const float *aim_sums, /* (n_rows, n_spots) summed shares, below 1 */ \
    const uint n_spots
#define HR_AIM aim_spot, aim_sums, n_spots

HR_FORCE_INLINE float3 hr_spot(__global const float *aim_spot, const uint spot)
{
    return (float3)(aim_spot[4 * spot], aim_spot[4 * spot + 1], aim_spot[4 * spot + 2]);
}

/* 1 - cos of half the angle at which a ball is seen, 0 from inside of it. */
HR_FORCE_INLINE float hr_cone(const float radius, const float square_distance)
{
    const float q = radius * radius / square_distance;
    return q < 1.0f ? q / (1.0f + sqrt(1.0f - q)) : 0.0f;
}

/* Density of a row's rays in the direction d from x, over that of the cosine law; cosine is that of d. */
HR_FORCE_INLINE float hr_aimed_density(const uint row, const float3 x, const float3 d, const float cosine, HR_AIM_PARAMS)
{
    __global const float *sums = aim_sums + (size_t)row * n_spots;
    const float aimed = sums[n_spots - 1];
    if (aimed <= 0.0f)
        return 1.0f;
    float density = 1.0f - aimed;
    float before = 0.0f;
    for (uint s = 0; s < n_spots; ++s) {
        const float share = sums[s] - before;
        before = sums[s];
        const float3 away = hr_spot(aim_spot, s) - x;
        const float3 beside = hr_cross(away, d);
        const float radius = aim_spot[4 * s + 3];
        if (share <= 0.0f || hr_dot(away, d) <= 0.0f || hr_dot(beside, beside) >= radius * radius)
            continue;
        const float cone = hr_cone(radius, hr_dot(away, away));
        if (cone > 0.0f)
            density += share * 0.5f / (cone * hr_larger(cosine, 1.0e-6f));
    }
    return density;
}

/* Direction from x at a spot, evenly over the angle at which it is seen, from two numbers in [0, 1); (0, 0, 0) from
   inside of it. */
HR_FORCE_INLINE float3 hr_aimed_direction(const uint spot, const float3 x, const float u, const float v,
                                          __global const float *aim_spot)
{
    const float3 away = hr_spot(aim_spot, spot) - x;
    const float square = hr_dot(away, away);
    const float cone = hr_cone(aim_spot[4 * spot + 3], square);
    if (cone <= 0.0f)
        return (float3)(0.0f);
    const float2 disk = hr_disk_point(u, v);
    const float3 axis = away / sqrt(square);
    float3 tangent, bitangent;
    hr_tangents(axis, &tangent, &bitangent);
    const float lower = (disk.x * disk.x + disk.y * disk.y) * cone;
    const float across = sqrt(cone * (2.0f - lower));
    return across * disk.x * tangent + across * disk.y * bitangent + (1.0f - lower) * axis;
}

#endif
