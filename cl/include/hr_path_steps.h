/* Steps that paths from readings share. */
#ifndef HR_PATH_STEPS_H
#define HR_PATH_STEPS_H

#include "include/hr_bvh.h"
#include "include/hr_elements.h"
#include "include/hr_outcomes.h"

/* Number `count` of the plain random numbers that `seed` begins. */
HR_FORCE_INLINE float hr_plain(const uint seed, const uint count)
{
    return hr_unit_float(hr_hash(seed + 0x9e3779b9u * count));
}

/* What a ray ended on, as a row element or an outcome. */
HR_FORCE_INLINE uint hr_row_of_hit(const hr_hit hit, const float3 direction, __global const uint *patch_solid,
                          __global const uint *cell_divisions, __global const uint *side_first_cell,
                          __global const uint *cell_row, __global const uint *patch_kind)
{
    if (hit.patch == HR_NONE)
        return direction.z > 0.0f ? HR_SKY : HR_MISS;
    const uint cell = hr_cell_at(hit.patch, hit.side, hit.u, hit.v, cell_divisions, side_first_cell, patch_kind);
    if (cell != HR_NONE)
        return cell_row[cell];
    return hit.side == HR_BACK && patch_solid[hit.patch] ? HR_COVERED : HR_UNLIT;
}

#endif
