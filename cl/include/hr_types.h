/* Types and small vector helpers shared by every kernel. */
#ifndef HR_TYPES_H
#define HR_TYPES_H

#define HR_NONE 0xFFFFFFFFu
#define HR_PI 3.14159265358979323846f
#define HR_INV_PI 0.31830988618379067154f

/* PoCL calls even one-line builtins (dot, cross, vload3, fmax) and saves all vector registers around the call, so
   inner loops use these instead. */
#define HR_FORCE_INLINE inline __attribute__((always_inline))

HR_FORCE_INLINE float hr_dot(const float3 a, const float3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

HR_FORCE_INLINE float3 hr_cross(const float3 a, const float3 b)
{
    return (float3)(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

HR_FORCE_INLINE float hr_larger(const float a, const float b)
{
    return a > b ? a : b;
}

HR_FORCE_INLINE float hr_smaller(const float a, const float b)
{
    return a < b ? a : b;
}

/* |x|; keeps the sign of -0. */
HR_FORCE_INLINE float hr_magnitude(float x)
{
    return x < 0.0f ? -x : x;
}

HR_FORCE_INLINE float hr_largest_magnitude(float3 v)
{
    const float x = hr_magnitude(v.x);
    const float y = hr_magnitude(v.y);
    const float z = hr_magnitude(v.z);
    const float xy = x > y ? x : y;
    return xy > z ? xy : z;
}

/* Adds to a long sum, whose lost digits `rest` keeps (Kahan 1965): a million terms in single precision go wrong by
   parts in a thousand otherwise. */
HR_FORCE_INLINE void hr_add(float *sum, float *rest, const float term)
{
    const float corrected = term - *rest;
    const float next = *sum + corrected;
    *rest = (next - *sum) - corrected;
    *sum = next;
}

/* Three packed coordinates, as numpy lays out a row of (n, 3). */
HR_FORCE_INLINE float3 hr_load3(__global const float *rows, const uint i)
{
    __global const float *row = rows + 3 * (size_t)i;
    return (float3)(row[0], row[1], row[2]);
}

/* Two tangents that make a right-handed frame with the unit normal n.
   Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
HR_FORCE_INLINE void hr_tangents(float3 n, float3 *t, float3 *b)
{
    const float sign = n.z >= 0.0f ? 1.0f : -1.0f;
    const float a = -1.0f / (sign + n.z);
    const float c = n.x * n.y * a;
    *t = (float3)(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    *b = (float3)(c, sign + n.y * n.y * a, -n.y);
}

#endif
