/* Flat patches on the device: corner, two edges, unit normal; kind 1 is the triangle u + v <= 1. */
#ifndef HR_PATCHES_H
#define HR_PATCHES_H

#include "include/hr_types.h"

#define HR_PATCH_PARAMS                                                    \
    __global const float *patch_origin, /* (n_patches, 3) [m]           */ \
    __global const float *patch_edge_u, /* (n_patches, 3) [m]           */ \
    __global const float *patch_edge_v, /* (n_patches, 3) [m]           */ \
    __global const float *patch_normal, /* (n_patches, 3) unit          */ \
    __global const uint *patch_kind     /* (n_patches,) 1 = a triangle  */
#define HR_PATCH patch_origin, patch_edge_u, patch_edge_v, patch_normal, patch_kind

#define HR_FRONT 0u
#define HR_BACK 1u

/* Low-distortion map of the unit square onto the triangle u + v <= 1 (Heitz 2019). */
HR_FORCE_INLINE float2 hr_square_to_triangle(const float s, const float t)
{
    return t > s ? (float2)(0.5f * s, t - 0.5f * s) : (float2)(s - 0.5f * t, 0.5f * t);
}

HR_FORCE_INLINE float3 hr_patch_point(const uint patch, const float u, const float v, HR_PATCH_PARAMS)
{
    return hr_load3(patch_origin, patch) + u * hr_load3(patch_edge_u, patch) + v * hr_load3(patch_edge_v, patch);
}

/* Unit normal of one side. */
HR_FORCE_INLINE float3 hr_side_normal(const uint patch, const uint side, __global const float *patch_normal)
{
    const float3 n = hr_load3(patch_normal, patch);
    return side == HR_FRONT ? n : -n;
}

#endif
