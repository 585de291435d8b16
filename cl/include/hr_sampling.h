/* Randomised quasi-random points and the directions made of them. */
#ifndef HR_SAMPLING_H
#define HR_SAMPLING_H

#include "include/hr_types.h"

#define HR_SOBOL_DIMENSIONS 8

/* Direction numbers of the first eight Sobol dimensions, new-joe-kuo-6 (Joe & Kuo 2008). */
__constant uint hr_sobol_directions[HR_SOBOL_DIMENSIONS * 32] = {
    0x80000000u, 0x40000000u, 0x20000000u, 0x10000000u, 0x08000000u, 0x04000000u, 0x02000000u, 0x01000000u,
    0x00800000u, 0x00400000u, 0x00200000u, 0x00100000u, 0x00080000u, 0x00040000u, 0x00020000u, 0x00010000u,
    0x00008000u, 0x00004000u, 0x00002000u, 0x00001000u, 0x00000800u, 0x00000400u, 0x00000200u, 0x00000100u,
    0x00000080u, 0x00000040u, 0x00000020u, 0x00000010u, 0x00000008u, 0x00000004u, 0x00000002u, 0x00000001u,
    0x80000000u, 0xc0000000u, 0xa0000000u, 0xf0000000u, 0x88000000u, 0xcc000000u, 0xaa000000u, 0xff000000u,
    0x80800000u, 0xc0c00000u, 0xa0a00000u, 0xf0f00000u, 0x88880000u, 0xcccc0000u, 0xaaaa0000u, 0xffff0000u,
    0x80008000u, 0xc000c000u, 0xa000a000u, 0xf000f000u, 0x88008800u, 0xcc00cc00u, 0xaa00aa00u, 0xff00ff00u,
    0x80808080u, 0xc0c0c0c0u, 0xa0a0a0a0u, 0xf0f0f0f0u, 0x88888888u, 0xccccccccu, 0xaaaaaaaau, 0xffffffffu,
    0x80000000u, 0xc0000000u, 0x60000000u, 0x90000000u, 0xe8000000u, 0x5c000000u, 0x8e000000u, 0xc5000000u,
    0x68800000u, 0x9cc00000u, 0xee600000u, 0x55900000u, 0x80680000u, 0xc09c0000u, 0x60ee0000u, 0x90550000u,
    0xe8808000u, 0x5cc0c000u, 0x8e606000u, 0xc5909000u, 0x6868e800u, 0x9c9c5c00u, 0xeeee8e00u, 0x5555c500u,
    0x8000e880u, 0xc0005cc0u, 0x60008e60u, 0x9000c590u, 0xe8006868u, 0x5c009c9cu, 0x8e00eeeeu, 0xc5005555u,
    0x80000000u, 0xc0000000u, 0x20000000u, 0x50000000u, 0xf8000000u, 0x74000000u, 0xa2000000u, 0x93000000u,
    0xd8800000u, 0x25400000u, 0x59e00000u, 0xe6d00000u, 0x78080000u, 0xb40c0000u, 0x82020000u, 0xc3050000u,
    0x208f8000u, 0x51474000u, 0xfbea2000u, 0x75d93000u, 0xa0858800u, 0x914e5400u, 0xdbe79e00u, 0x25db6d00u,
    0x58800080u, 0xe54000c0u, 0x79e00020u, 0xb6d00050u, 0x800800f8u, 0xc00c0074u, 0x200200a2u, 0x50050093u,
    0x80000000u, 0x40000000u, 0x20000000u, 0xb0000000u, 0xf8000000u, 0xdc000000u, 0x7a000000u, 0x9d000000u,
    0x5a800000u, 0x2fc00000u, 0xa1600000u, 0xf0b00000u, 0xda880000u, 0x6fc40000u, 0x81620000u, 0x40bb0000u,
    0x22878000u, 0xb3c9c000u, 0xfb65a000u, 0xddb2d000u, 0x78022800u, 0x9c0b3c00u, 0x5a0fb600u, 0x2d0ddb00u,
    0xa2878080u, 0xf3c9c040u, 0xdb65a020u, 0x6db2d0b0u, 0x800228f8u, 0x400b3cdcu, 0x200fb67au, 0xb00ddb9du,
    0x80000000u, 0x40000000u, 0x60000000u, 0x30000000u, 0xc8000000u, 0x24000000u, 0x56000000u, 0xfb000000u,
    0xe0800000u, 0x70400000u, 0xa8600000u, 0x14300000u, 0x9ec80000u, 0xdf240000u, 0xb6d60000u, 0x8bbb0000u,
    0x48008000u, 0x64004000u, 0x36006000u, 0xcb003000u, 0x2880c800u, 0x54402400u, 0xfe605600u, 0xef30fb00u,
    0x7e48e080u, 0xaf647040u, 0x1eb6a860u, 0x9f8b1430u, 0xd6c81ec8u, 0xbb249f24u, 0x80d6d6d6u, 0x40bbbbbbu,
    0x80000000u, 0xc0000000u, 0xa0000000u, 0xd0000000u, 0x58000000u, 0x94000000u, 0x3e000000u, 0xe3000000u,
    0xbe800000u, 0x23c00000u, 0x1e200000u, 0xf3100000u, 0x46780000u, 0x67840000u, 0x78460000u, 0x84670000u,
    0xc6788000u, 0xa784c000u, 0xd846a000u, 0x5467d000u, 0x9e78d800u, 0x33845400u, 0xe6469e00u, 0xb7673300u,
    0x20f86680u, 0x104477c0u, 0xf8668020u, 0x4477c010u, 0x668020f8u, 0x77c01044u, 0x8020f866u, 0xc0104477u,
    0x80000000u, 0x40000000u, 0xa0000000u, 0x50000000u, 0x88000000u, 0x24000000u, 0x12000000u, 0x2d000000u,
    0x76800000u, 0x9e400000u, 0x08200000u, 0x64100000u, 0xb2280000u, 0x7d140000u, 0xfea20000u, 0xba490000u,
    0x1a248000u, 0x491b4000u, 0xc4b5a000u, 0xe3739000u, 0xf6800800u, 0xde400400u, 0xa8200a00u, 0x34100500u,
    0x3a280880u, 0x59140240u, 0xeca20120u, 0x974902d0u, 0x6ca48768u, 0xd75b49e4u, 0xcc95a082u, 0x87639641u
};

/* Point `index` of Sobol dimension `dimension`, as 32 bits after the binary point. */
HR_FORCE_INLINE uint hr_sobol(uint index, const uint dimension)
{
    uint bits = 0;
    for (uint k = dimension * 32; index != 0; index >>= 1, ++k)
        bits ^= (index & 1u) ? hr_sobol_directions[k] : 0u;
    return bits;
}

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
   the seed and on the bits before it. Laine & Karras 2011; Burley 2020, "Practical Hash-based Owen Scrambling". */
HR_FORCE_INLINE uint hr_owen(uint bits, const uint seed)
{
    uint x = hr_reverse_bits(bits);
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
    return hr_unit_float(hr_owen(hr_sobol(index, dimension), hr_hash(seed + 0x632be5abu * (dimension + 1u))));
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

/* Direction about the unit normal n with density cos/pi, from two numbers in [0, 1).
   Malley's method over the concentric map of the square to the disk (Shirley & Chiu 1997). */
HR_FORCE_INLINE float3 hr_cosine_direction(const float3 n, const float u, const float v)
{
    const float a = 2.0f * u - 1.0f;
    const float b = 2.0f * v - 1.0f;
    const int wide = a * a > b * b;
    const float radius = wide ? a : b;
    const float angle = radius == 0.0f ? 0.0f : 0.25f * HR_PI * ((wide ? b : a) / radius);
    const float along = radius * hr_cos_small(angle);
    const float across = radius * hr_sin_small(angle);
    float3 tangent, bitangent;
    hr_tangents(n, &tangent, &bitangent);
    const float x = wide ? along : across;
    const float y = wide ? across : along;
    const float z = sqrt(hr_larger(1.0f - x * x - y * y, 1.0e-12f));
    return x * tangent + y * bitangent + z * n;
}

#endif
