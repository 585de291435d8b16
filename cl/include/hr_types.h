/* Types and small vector helpers shared by every kernel. */
#ifndef HR_TYPES_H
#define HR_TYPES_H

#ifndef HR_REAL
#define HR_REAL float
#endif

typedef HR_REAL real;

#define HR_NONE 0xFFFFFFFFu
#define HR_PI 3.14159265358979323846f
#define HR_INV_PI 0.31830988618379067154f

/* Three packed coordinates, as numpy lays out a row of (n, 3). */
inline float3 hr_load3(__global const float *rows, uint i)
{
    return vload3(i, rows);
}

/* Unit vector along v. v must not be 0. */
inline float3 hr_unit(float3 v)
{
    return v / sqrt(dot(v, v));
}

/* Two tangents that make a right-handed frame with the unit normal n.
   Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
inline void hr_tangents(float3 n, float3 *t, float3 *b)
{
    const float sign = n.z >= 0.0f ? 1.0f : -1.0f;
    const float a = -1.0f / (sign + n.z);
    const float c = n.x * n.y * a;
    *t = (float3)(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    *b = (float3)(c, sign + n.y * n.y * a, -n.y);
}

#endif
