/* Steps of images: order of the pixels' random numbers, and the light of one drawn lamp at a surface point. */
#ifndef HR_IMAGE_H
#define HR_IMAGE_H

#include "include/hr_bvh.h"
#include "include/hr_emitters.h"
#include "include/hr_outcomes.h"
#include "include/hr_sampling.h"

/* The lower 16 bits of x, each with a 0 before it. */
HR_FORCE_INLINE uint hr_spread_bits(uint x)
{
    x &= 0xffffu;
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

/* Place of a pixel along a shuffled Z curve over a picture of at most 2^levels x 2^levels pixels. Pixels of any square
   of the quadtree come one after the other, so that one sequence over the whole picture is well spread in each pixel
   and over each square too: the noise of neighbours differs (Ahmed & Wonka 2020, "Screen-space blue-noise diffusion of
   Monte Carlo sampling error via hierarchical ordering of pixels"). Shuffled as Owen scrambles points. */
HR_FORCE_INLINE uint hr_pixel_order(const uint x, const uint y, const uint levels, const uint seed)
{
    const uint code = hr_spread_bits(x) | (hr_spread_bits(y) << 1);
    const uint unused = 32u - 2u * levels;
    return hr_owen(hr_reverse_bits(code << unused), seed) >> unused;
}

/* A lamp that was tried at a surface point, for unit emission: its number, and what is added for it. near: its sample is
   weighed against directions drawn by the cosine law, and what they find is to be added (hr_found_on_ray). clear: its
   closed form counts already, so that only what is found hidden is taken off, and else what is found open is added. */
typedef struct {
    uint emitter;
    float probability;
    float gain;
    int near;
    int clear;
} hr_tried_lamp;

/* Draws the lamp that a shadow ray goes to, and one point of it. Lamps of which the row's points saw most are `clear`:
   they count by their closed forms, which has no noise in full light; the others by what is found open, which has none in
   full shadow. Neither has a bias. Lamps are drawn by how much of their light is in doubt. */
HR_FORCE_INLINE hr_tried_lamp hr_try_lamp(const float3 x, const float3 n, const uint own, const uint row,
                                          const float3 numbers, __global const float *lamp_choice,
                                          __global const uchar *lamp_clear, const uint n_emitters,
                                          const uint occlusion, const float scale, HR_EMITTER_PARAMS, HR_PATCH_PARAMS,
                                          HR_BVH_PARAMS)
{
    hr_tried_lamp lamp = {0, 1.0f, 0.0f, 0, 0};
    if (n_emitters == 0)
        return lamp;
    const int known = HR_IS_ROW(row);
    const size_t at = known ? (size_t)row * n_emitters : 0;
    const uint e = known ? hr_draw(lamp_choice + at, n_emitters, numbers.z)
                         : (uint)hr_smaller(numbers.z * (float)n_emitters, (float)(n_emitters - 1));
    lamp.emitter = e;
    lamp.clear = known && lamp_clear[at + e];
    if (lamp.clear && !occlusion)
        return lamp;
    lamp.probability =
        known ? lamp_choice[at + e] - (e > 0 ? lamp_choice[at + e - 1] : 0.0f) : 1.0f / (float)n_emitters;
    const uint patch = emitter_patch[e];
    if (own == patch)
        return lamp;
    const float far_area = patch == HR_NONE ? 1.0f : hr_far_area(x, e, HR_EMITTER);
    lamp.near = occlusion && far_area <= 0.0f;
    const float3 y = hr_emitter_point(e, numbers.x, numbers.y, HR_EMITTER, HR_PATCH);
    const float drawn = lamp.near        ? hr_balanced_weight(x, n, y, e, HR_EMITTER, HR_PATCH)
                        : far_area > 0.0f ? far_area * hr_emitter_weight(x, n, y, e, HR_EMITTER, HR_PATCH)
                                          : hr_emitter_factor(x, n, e, HR_EMITTER, HR_PATCH);
    if (drawn <= 0.0f)
        return lamp;
    const float3 origin = hr_offset_origin(x, n, scale);
    const int hidden = occlusion && hr_any_hit(HR_BVH, origin, y - origin, 1.0f, own, patch);
    if (hidden == lamp.clear)
        lamp.gain = hidden ? -drawn : drawn;
    return lamp;
}

#endif
