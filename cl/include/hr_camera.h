/* A pinhole camera. */
#ifndef HR_CAMERA_H
#define HR_CAMERA_H

#include "include/hr_types.h"

/* Direction through the point (x, y) of the picture, both 0 … 1 from the upper left corner; not a unit vector.
   right, down: half the picture's width and height at distance 1 along the unit vector forward. */
inline float3 hr_view_direction(const float x, const float y, const float3 forward, const float3 right,
                                const float3 down)
{
    return forward + (2.0f * x - 1.0f) * right + (2.0f * y - 1.0f) * down;
}

#endif
