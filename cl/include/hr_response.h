/* How much of the light from a direction counts at a reading that is no plane: its own response over the cosines of the
   planes that it is made of (`hradiosity.model.sensor_kinds` makes planes and tables). */
#ifndef HR_RESPONSE_H
#define HR_RESPONSE_H

#include "include/hr_types.h"

#define HR_RESPONSE_ENTRIES 12
#define HR_SPHERE 1.0f
#define HR_CYLINDER 2.0f
#define HR_HALF_CYLINDER 3.0f

/* Whether a direction lies in the field of view: inside of the ellipse with half axes `across` and `along` [rad] that
   belongs to its quarter, in the plane in which the distance from the middle is the angle from the line of sight. */
HR_FORCE_INLINE int hr_in_field(const float ahead, const float left, const float up, __global const float *limits)
{
    const float off = sqrt(left * left + up * up);
    if (off <= 0.0f)
        return ahead > 0.0f;
    const float angle = atan2(off, ahead);
    const float x = angle * left / (off * (left > 0.0f ? limits[2] : limits[3]));
    const float y = angle * up / (off * (up > 0.0f ? limits[0] : limits[1]));
    return x * x + y * y <= 1.0f;
}

/* Weight of light from the unit direction d; row: u (3), a (3), kind, limits up, down, left, right [rad] or 0, unused. */
HR_FORCE_INLINE float hr_response(__global const float *table, const uint point, const float3 d)
{
    __global const float *row = table + HR_RESPONSE_ENTRIES * (size_t)point;
    const float3 u = (float3)(row[0], row[1], row[2]), a = (float3)(row[3], row[4], row[5]);
    const float ahead = hr_dot(d, u), left = hr_dot(d, hr_cross(a, u)), up = hr_dot(d, a);
    const float kind = row[6];
    if (row[7] > 0.0f && !hr_in_field(ahead, left, up, row + 7))
        return 0.0f;
    if (kind == HR_SPHERE) {
        const float planes = hr_larger(ahead + left + up, 0.0f) + hr_larger(ahead - left - up, 0.0f) +
                             hr_larger(left - ahead - up, 0.0f) + hr_larger(up - ahead - left, 0.0f);
        return 0.25f * 1.73205081f / planes;
    }
    const float level = sqrt(ahead * ahead + left * left);
    if (kind == HR_CYLINDER) {
        const float across = 0.866025404f * left;
        const float planes = hr_larger(ahead, 0.0f) + hr_larger(across - 0.5f * ahead, 0.0f) +
                             hr_larger(-across - 0.5f * ahead, 0.0f);
        return planes > 0.0f ? HR_INV_PI * level / planes : 0.0f;
    }
    if (kind == HR_HALF_CYLINDER) {
        const float planes = hr_larger(ahead, 0.0f) + hr_magnitude(left);
        return planes > 0.0f ? HR_INV_PI * (level + ahead) / planes : 0.0f;
    }
    return 1.0f;
}

#endif
