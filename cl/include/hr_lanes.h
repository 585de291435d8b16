/* Lanes, bits, magnitudes and minima for inner loops.

   PoCL calls even one-line builtins (vload8, any, fabs, fmin, popcount) and saves all vector registers around the
   call; that halves the speed of a traversal. These are inlined without fail. See suites/bench_rays. */
#ifndef HR_LANES_H
#define HR_LANES_H

#include "include/hr_types.h"

/* Axis of the largest magnitude: 0, 1 or 2. */
HR_FORCE_INLINE uint hr_main_axis(float3 v)
{
    const float x = hr_magnitude(v.x);
    const float y = hr_magnitude(v.y);
    const float z = hr_magnitude(v.z);
    return x >= y && x >= z ? 0u : y >= z ? 1u : 2u;
}

HR_FORCE_INLINE float hr_component(float3 v, uint axis)
{
    return axis == 0u ? v.x : axis == 1u ? v.y : v.z;
}

HR_FORCE_INLINE float8 hr_larger8(float8 a, float8 b)
{
    return a > b ? a : b;
}

HR_FORCE_INLINE float8 hr_smaller8(float8 a, float8 b)
{
    return a < b ? a : b;
}

/* x86 has instructions for the next two that no portable expression becomes; with them rays are 15 to 20 % faster.
   HR_PORTABLE_LANES asks for the portable forms all the same. */
#if defined(__AVX__) && defined(__clang__) && !defined(HR_PORTABLE_LANES)
#define HR_X86_LANES
#endif

/* One bit for each true lane. */
HR_FORCE_INLINE uint hr_lanes(int8 truth)
{
#ifdef HR_X86_LANES
    return (uint)__builtin_ia32_movmskps256(as_float8(truth));
#else
    const int8 bits = truth & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 fours = bits.lo | bits.hi;
    const int2 twos = fours.lo | fours.hi;
    return (uint)(twos.x | twos.y);
#endif
}

/* Number of the lowest of 8 bits. bits must not be 0. The product is a perfect hash of the powers of 2 below 256
   (Leiserson, Prokop, Randall 1998); the constant holds the numbers in the order of the hash. */
HR_FORCE_INLINE uint hr_lowest_bit(uint bits)
{
#ifdef HR_X86_LANES
    return (uint)__builtin_ctz(bits);
#else
    const uint hash = (((bits & (0u - bits)) * 0x1Du) >> 5) & 7u;
    return (0x34572610u >> (4u * hash)) & 7u;
#endif
}

#endif
