/* Top-down building of an 8-wide hierarchy by the binned surface area heuristic (Wald 2007).

   Bounds are 8 floats, (lowest x, y, z, 0, -highest x, -y, -z, 0), so that joining two is one minimum. */
#ifndef HR_BVH_BUILD_H
#define HR_BVH_BUILD_H

#include "include/hr_lanes.h"
#include "include/hr_types.h"

#define HR_BVH_BINS 32
#define HR_BVH_LEAF_SIZE 8u

HR_FORCE_INLINE float8 hr_no_bounds(void)
{
    return (float8)(INFINITY, INFINITY, INFINITY, 0.0f, INFINITY, INFINITY, INFINITY, 0.0f);
}

HR_FORCE_INLINE float8 hr_join_bounds(float8 a, float8 b)
{
    return hr_smaller8(a, b);
}

/* Half the surface of a box; 0 for the bounds of nothing. */
HR_FORCE_INLINE float hr_half_area(float8 bounds)
{
    const float4 extent = -(bounds.lo + bounds.hi);
    return extent.x < 0.0f ? 0.0f : extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
}

/* Twice the centre of a box, as bounds of a point: (c, 0, -c, 0). */
HR_FORCE_INLINE float8 hr_doubled_centre(float8 bounds)
{
    return bounds - bounds.s45670123;
}

/* Cost of a set under one box: probability of being met x triangles. Counting groups of 8 instead, as leaves are
   tested, gave a quarter more leaf tests. */
HR_FORCE_INLINE float hr_set_cost(float8 bounds, uint count)
{
    return hr_half_area(bounds) * (float)count;
}

/* Bins along x, y, z of a doubled centre within centre_bounds; bins_per_length is a little too small, so that rounding
   can't give bin HR_BVH_BINS. */
HR_FORCE_INLINE uint4 hr_bins(float8 centre, float8 centre_bounds, float4 bins_per_length)
{
    const float4 bin = (centre.lo - centre_bounds.lo) * bins_per_length;
    return (uint4)((uint)bin.x, (uint)bin.y, (uint)bin.z, 0u);
}

HR_FORCE_INLINE float8 hr_bounds_of(__global const float8 *boxes, uint begin, uint end, float8 *centre_bounds)
{
    float8 bounds = hr_no_bounds();
    float8 centres = hr_no_bounds();
    for (uint i = begin; i < end; i++) {
        const float8 box = boxes[i];
        bounds = hr_join_bounds(bounds, box);
        centres = hr_join_bounds(centres, hr_doubled_centre(box));
    }
    *centre_bounds = centres;
    return bounds;
}

/* Cheapest plane between bins: axis (3: there is none) and first bin on the right. */
HR_FORCE_INLINE uint2 hr_best_plane(__global const float8 *boxes, uint begin, uint end, float8 centre_bounds,
                           float4 bins_per_length)
{
    float8 bounds[3][HR_BVH_BINS];
    uint count[3][HR_BVH_BINS];
    for (uint axis = 0; axis < 3; axis++)
        for (uint bin = 0; bin < HR_BVH_BINS; bin++) {
            bounds[axis][bin] = hr_no_bounds();
            count[axis][bin] = 0u;
        }
    for (uint i = begin; i < end; i++) {
        const float8 box = boxes[i];
        const uint4 bin = hr_bins(hr_doubled_centre(box), centre_bounds, bins_per_length);
        bounds[0][bin.x] = hr_join_bounds(bounds[0][bin.x], box);
        bounds[1][bin.y] = hr_join_bounds(bounds[1][bin.y], box);
        bounds[2][bin.z] = hr_join_bounds(bounds[2][bin.z], box);
        count[0][bin.x]++;
        count[1][bin.y]++;
        count[2][bin.z]++;
    }
    uint2 best = (uint2)(3u, 0u);
    float best_cost = INFINITY;
    for (uint axis = 0; axis < 3; axis++) {
        float right_cost[HR_BVH_BINS];
        float8 joined = hr_no_bounds();
        uint joined_count = 0u;
        for (uint bin = HR_BVH_BINS - 1; bin > 0; bin--) {
            joined = hr_join_bounds(joined, bounds[axis][bin]);
            joined_count += count[axis][bin];
            right_cost[bin] = joined_count ? hr_set_cost(joined, joined_count) : INFINITY;
        }
        joined = hr_no_bounds();
        joined_count = 0u;
        for (uint bin = 1; bin < HR_BVH_BINS; bin++) {
            joined = hr_join_bounds(joined, bounds[axis][bin - 1]);
            joined_count += count[axis][bin - 1];
            const float cost = joined_count ? hr_set_cost(joined, joined_count) + right_cost[bin] : INFINITY;
            if (cost < best_cost) {
                best_cost = cost;
                best = (uint2)(axis, bin);
            }
        }
    }
    return best;
}

/* Orders begin..end so that two sets are apart; returns where the second begins. There must be two boxes or more. */
HR_FORCE_INLINE uint hr_split_range(__global float8 *boxes, __global uint *names, uint begin, uint end, int halve)
{
    const uint middle = begin + (end - begin) / 2u;
    if (halve)
        return middle;
    float8 centres;
    hr_bounds_of(boxes, begin, end, &centres);
    const float4 extent = -(centres.lo + centres.hi);
    const float4 bins_per_length = extent > 0.0f ? (0.9999f * HR_BVH_BINS) / extent : (float4)(0.0f);
    const uint2 plane = hr_best_plane(boxes, begin, end, centres, bins_per_length);
    if (plane.x == 3u)
        return middle;
    uint left = begin;
    uint right = end;
    while (left < right) {
        const float8 box = boxes[left];
        const uint4 bins = hr_bins(hr_doubled_centre(box), centres, bins_per_length);
        const uint bin = plane.x == 0u ? bins.x : plane.x == 1u ? bins.y : bins.z;
        if (bin < plane.y) {
            left++;
            continue;
        }
        right--;
        boxes[left] = boxes[right];
        boxes[right] = box;
        const uint name = names[left];
        names[left] = names[right];
        names[right] = name;
    }
    return left;
}

/* Cuts begin..end into at most 8 sets: the one with the largest surface (with halve: the most boxes) is split until
   there are 8, or all fit in leaves. Returns the number of sets. */
HR_FORCE_INLINE uint hr_split_node(__global float8 *boxes, __global uint *names, uint begin, uint end, int halve,
                          float8 *set_bounds, uint *set_begin, uint *set_end)
{
    float8 centres;
    uint n = 1u;
    set_begin[0] = begin;
    set_end[0] = end;
    set_bounds[0] = hr_bounds_of(boxes, begin, end, &centres);
    while (n < 8u) {
        uint widest = n;
        float size = -1.0f;
        for (uint i = 0; i < n; i++) {
            const uint count = set_end[i] - set_begin[i];
            const float own = halve ? (float)count : hr_half_area(set_bounds[i]);
            if (count > HR_BVH_LEAF_SIZE && own > size) {
                size = own;
                widest = i;
            }
        }
        if (widest == n)
            break;
        const uint middle = hr_split_range(boxes, names, set_begin[widest], set_end[widest], halve);
        set_begin[n] = middle;
        set_end[n] = set_end[widest];
        set_end[widest] = middle;
        set_bounds[widest] = hr_bounds_of(boxes, set_begin[widest], middle, &centres);
        set_bounds[n] = hr_bounds_of(boxes, middle, set_end[n], &centres);
        n++;
    }
    return n;
}

#endif
