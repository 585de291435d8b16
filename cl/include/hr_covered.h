/* Whether a ray started inside a solid. */
#ifndef HR_COVERED_H
#define HR_COVERED_H

#include "include/hr_bvh.h"
#include "include/hr_patches.h"

#define HR_FLUSH_SLACK 0x1p-17f /* of the scene's half extent: more than flush surfaces and rounding are apart */

#define HR_SOLID_PARAMS                                                                                         \
    __global const uint *patch_solid,     /* (n_patches,) 0, or 1 + the solid whose matter is behind         */ \
        __global const float *flush_reach /* (n_patches, 2) diameter of solids flush with front, back; 0: none */
#define HR_SOLID patch_solid, flush_reach

/* 1 if the ray along the unit `direction`, which met `hit`, meets the back of a solid there. Where a solid's face lies
   in another surface, the ray leaves the solid and meets the surface at one place, and rounding decided which of them
   `hit` is: a second ray past that place finds the other. It starts on the way that was found free, so that it can't
   be inside another solid. */
HR_FORCE_INLINE int hr_leaves_solid(const hr_hit hit, const float3 origin, const float3 direction, const float scale,
                                    __global const float *patch_normal, HR_SOLID_PARAMS, HR_BVH_PARAMS)
{
    const uint solid = patch_solid[hit.patch];
    if (hit.side == HR_BACK && solid)
        return 1;
    if (hit.t > flush_reach[2 * hit.patch + hit.side])
        return 0;
    const float cosine = hr_magnitude(dot(direction, hr_load3(patch_normal, hit.patch)));
    const float slack = HR_FLUSH_SLACK * scale / fmax(cosine, 1e-6f);
    const float before = fmin(slack, hit.t);
    const hr_hit other =
        hr_closest_hit(HR_BVH, origin + (hit.t - before) * direction, direction, before + slack, hit.patch);
    return other.patch != HR_NONE && other.side == HR_BACK && patch_solid[other.patch] != 0u &&
           patch_solid[other.patch] != solid;
}

#endif
