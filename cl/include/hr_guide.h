/* Directions drawn by a table of the light that a point was found to receive from each part of its hemisphere. */
#ifndef HR_GUIDE_H
#define HR_GUIDE_H

#include "include/hr_types.h"

/* The unit square whose points stand for directions is halved so many times along each edge. Values as in
   hradiosity/readings/guide.py; images set fewer levels (hradiosity/show/image_guide.py). */
#ifndef HR_GUIDE_LEVELS
#define HR_GUIDE_LEVELS 5u
#endif
#define HR_GUIDE_SIDE (1u << HR_GUIDE_LEVELS)
/* 4 + 16 + ... + side * side */
#define HR_GUIDE_ENTRIES ((HR_GUIDE_SIDE * HR_GUIDE_SIDE - 1u) / 3u * 4u)

/* Warps an even point of the unit square to one with the table's density, quarter by quarter, so that well spread
   points stay well spread (Clarberg, Jarosz, Akenine-Moeller & Jensen 2005, "Wavelet importance sampling").
   table: shares of the 2 x 2, 4 x 4, ... parts, each level by rows and with the sum 1, none of them 0.
   Returns the point and 1 over the density. */
HR_FORCE_INLINE float3 hr_guide(__global const float *table, float u, float v)
{
    uint x = 0, y = 0, side = 2;
    float share = 1.0f;
    __global const float *level = table;
    for (uint l = 0; l < HR_GUIDE_LEVELS; ++l) {
        __global const float *part = level + 2u * y * side + 2u * x;
        const float left = part[0] + part[side];
        const float right = part[1] + part[side + 1u];
        const float to_left = left / (left + right);
        const uint on_right = u >= to_left;
        u = on_right ? (u - to_left) / (1.0f - to_left) : u / to_left;
        const float low = part[on_right];
        const float high = part[side + on_right];
        const float to_low = low / (low + high);
        const uint on_high = v >= to_low;
        v = on_high ? (v - to_low) / (1.0f - to_low) : v / to_low;
        share = on_high ? high : low;
        x = 2u * x + on_right;
        y = 2u * y + on_high;
        level += side * side;
        side *= 2u;
    }
    const float cell = 1.0f / (float)HR_GUIDE_SIDE;
    const float most = 1.0f - 0x1.0p-24f;
    return (float3)(((float)x + hr_smaller(u, most)) * cell, ((float)y + hr_smaller(v, most)) * cell,
                    cell * cell / share);
}

#endif
