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

/* Parts of so many kinds may be cut into 4 x 4: those of the square, and those that this makes. */
#define HR_GUIDE_CUTS 2u
#define HR_GUIDE_BLOCK_ENTRIES 20u

/* Where a point has come to: in a part (x, y), at (u, v) inside of it, whose share this is. */
typedef struct {
    float u, v, share;
    uint x, y;
} hr_guide_place;

/* Goes down `levels` levels of 2 x 2, 4 x 4, ... shares, each by rows, quarter by quarter. */
HR_FORCE_INLINE void hr_guide_descend(hr_guide_place *place, __global const float *level, const uint levels)
{
    uint x = 0, y = 0, side = 2;
    for (uint l = 0; l < levels; ++l) {
        __global const float *part = level + 2u * y * side + 2u * x;
        const float left = part[0] + part[side];
        const float right = part[1] + part[side + 1u];
        const float to_left = left / (left + right);
        const uint on_right = place->u >= to_left;
        place->u = on_right ? (place->u - to_left) / (1.0f - to_left) : place->u / to_left;
        const float low = part[on_right];
        const float high = part[side + on_right];
        const float to_low = low / (low + high);
        const uint on_high = place->v >= to_low;
        place->v = on_high ? (place->v - to_low) / (1.0f - to_low) : place->v / to_low;
        place->share = on_high ? high : low;
        x = 2u * x + on_right;
        y = 2u * y + on_high;
        level += side * side;
        side *= 2u;
    }
    place->x = (place->x << levels) + x;
    place->y = (place->y << levels) + y;
}

/* The point of the whole square, which has `side` x `side` parts where it is, and 1 over the density there. */
HR_FORCE_INLINE float3 hr_guided(const hr_guide_place *place, const uint side)
{
    const float cell = 1.0f / (float)side;
    const float most = 1.0f - 0x1.0p-24f;
    return (float3)(((float)place->x + hr_smaller(place->u, most)) * cell,
                    ((float)place->y + hr_smaller(place->v, most)) * cell, cell * cell / place->share);
}

/* Warps an even point of the unit square to one with the table's density, quarter by quarter, so that well spread
   points stay well spread (Clarberg, Jarosz, Akenine-Moeller & Jensen 2005, "Wavelet importance sampling").
   table: shares of the 2 x 2, 4 x 4, ... parts, each level by rows and with the sum 1, none of them 0.
   Returns the point and 1 over the density. */
HR_FORCE_INLINE float3 hr_guide(__global const float *table, const float u, const float v)
{
    hr_guide_place place = {u, v, 1.0f, 0u, 0u};
    hr_guide_descend(&place, table, HR_GUIDE_LEVELS);
    return hr_guided(&place, HR_GUIDE_SIDE);
}

/* Number of an entry in an ascending list, or HR_NONE. */
HR_FORCE_INLINE uint hr_guide_find(__global const uint *list, const uint n, const uint wanted)
{
    uint low = 0, high = n;
    while (low < high) {
        const uint middle = (low + high) / 2u;
        if (list[middle] < wanted)
            low = middle + 1u;
        else
            high = middle;
    }
    return low < n && list[low] == wanted ? low : HR_NONE;
}

/* The same where some parts are cut into blocks of 4 x 4, and some of these again.
   key: which, ascending: parts by their number, then, from HR_GUIDE_SIDE^2 on, those of the square cut 4 times as fine.
   block: (n_blocks, 4 + 16) shares of each, whose sums are the share of what is cut. */
HR_FORCE_INLINE float3 hr_fine_guide(__global const float *table, __global const uint *key, const uint n_blocks,
                                     __global const float *block, const float u, const float v)
{
    hr_guide_place place = {u, v, 1.0f, 0u, 0u};
    hr_guide_descend(&place, table, HR_GUIDE_LEVELS);
    uint side = HR_GUIDE_SIDE, first = 0;
    for (uint cut = 0; cut < HR_GUIDE_CUTS; ++cut) {
        const uint found = hr_guide_find(key, n_blocks, first + place.y * side + place.x);
        if (found == HR_NONE)
            break;
        hr_guide_descend(&place, block + (size_t)found * HR_GUIDE_BLOCK_ENTRIES, 2u);
        first += side * side;
        side *= 4u;
    }
    return hr_guided(&place, side);
}

#endif
