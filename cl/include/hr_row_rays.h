/* What becomes of rays from row elements. */
#ifndef HR_ROW_RAYS_H
#define HR_ROW_RAYS_H

#include "include/hr_covered.h"
#include "include/hr_elements.h"
#include "include/hr_outcomes.h"

/* What a ray from a row met, as a row element or an outcome. */
HR_FORCE_INLINE uint hr_ray_outcome(const hr_hit hit, const float3 origin, const float3 direction, const float scale,
                                    __global const uint *cell_divisions, __global const uint *side_first_cell,
                                    __global const uint *cell_row, __global const uint *patch_kind,
                                    __global const float *patch_normal, HR_SOLID_PARAMS, HR_BVH_PARAMS)
{
    if (hit.patch == HR_NONE)
        return direction.z > 0.0f ? HR_SKY : HR_MISS;
    if (hr_leaves_solid(hit, origin, direction, scale, patch_normal, HR_SOLID, HR_BVH))
        return HR_COVERED;
    const uint cell = hr_cell_at(hit.patch, hit.side, hit.u, hit.v, cell_divisions, side_first_cell, patch_kind);
    return cell == HR_NONE ? HR_UNLIT : cell_row[cell];
}

#endif
