/* Randomised quasi-random points and the directions made of them. */
#ifndef HR_SAMPLING_H
#define HR_SAMPLING_H

#include "include/hr_sobol.h"

/* Well mixed 32 bits of x: the "lowbias32" finaliser found by C. Wellons' hash search (2018). */
HR_FORCE_INLINE uint hr_hash(uint x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    x ^= x >> 15;
    return x;
}

HR_FORCE_INLINE uint hr_combine(const uint seed, const uint value)
{
    return hr_hash(seed ^ (hr_hash(value) + 0x9e3779b9u + (seed << 6) + (seed >> 2)));
}

/* The bytes change places as a vector: shifts alone would become an instruction that Oclgrind does not know. */
HR_FORCE_INLINE uint hr_reverse_bits(uint x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return as_uint(as_uchar4(x).wzyx);
}

/* Owen's nested uniform scramble of the bits after the binary point, by hashing: each bit is flipped depending on
   the seed and on the bits before it. Laine & Karras 2011; Burley 2020, "Practical Hash-based Owen Scrambling".
   x: the bits, the last one first; the result has them in their usual order. */
HR_FORCE_INLINE uint hr_owen(uint x, const uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return hr_reverse_bits(x);
}

/* 24 high bits as a number in [0, 1). */
HR_FORCE_INLINE float hr_unit_float(const uint bits)
{
    return (float)(bits >> 8) * 0x1.0p-24f;
}

/* Coordinate `dimension` of point `index` of the sequence that `seed` scrambles. */
HR_FORCE_INLINE float hr_sample(const uint index, const uint dimension, const uint seed)
{
    return hr_unit_float(hr_owen(hr_sobol_reversed(index, dimension), hr_hash(seed + 0x632be5abu * (dimension + 1u))));
}

/* sin x and cos x for |x| <= pi/4, by the polynomials of the Cephes library (Moshier); error below 1e-7. The driver's
   own functions are calls that cost as much as a fifth of a ray. */
HR_FORCE_INLINE float hr_sin_small(const float x)
{
    const float z = x * x;
    return ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
}

HR_FORCE_INLINE float hr_cos_small(const float x)
{
    const float z = x * x;
    return ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z - 0.5f * z + 1.0f;
}

/* Point of the unit disk for a point of the unit square, by the concentric map (Shirley & Chiu 1997). */
HR_FORCE_INLINE float2 hr_disk_point(const float u, const float v)
{
    const float a = 2.0f * u - 1.0f;
    const float b = 2.0f * v - 1.0f;
    const int wide = a * a > b * b;
    const float radius = wide ? a : b;
    const float angle = radius == 0.0f ? 0.0f : 0.25f * HR_PI * ((wide ? b : a) / radius);
    const float along = radius * hr_cos_small(angle);
    const float across = radius * hr_sin_small(angle);
    return (float2)(wide ? along : across, wide ? across : along);
}

/* Direction about the unit normal n with density cos/pi, from two numbers in [0, 1), by Malley's method. */
HR_FORCE_INLINE float3 hr_cosine_direction(const float3 n, const float u, const float v)
{
    const float2 at = hr_disk_point(u, v);
    float3 tangent, bitangent;
    hr_tangents(n, &tangent, &bitangent);
    const float z = sqrt(hr_larger(1.0f - at.x * at.x - at.y * at.y, 1.0e-12f));
    return at.x * tangent + at.y * bitangent + z * n;
}

/* First entry of the ascending row of n sums that is greater than x. */
HR_FORCE_INLINE uint hr_draw(__global const float *sums, const uint n, const float x)
{
    uint low = 0, high = n - 1;
    while (low < high) {
        const uint middle = (low + high) / 2;
        if (x < sums[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

#endif
