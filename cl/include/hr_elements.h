/* Row elements: where a hit belongs, and random points on an element. */
#ifndef HR_ELEMENTS_H
#define HR_ELEMENTS_H

#include "include/hr_patches.h"
#include "include/hr_sampling.h"

/* A patch side is cut into cells: nu x nv sub-parallelograms (index iu + nu iv), or n x n sub-triangles listed by
   rows of decreasing length. Every cell belongs to one row element; an element may own cells of several patches. */
#define HR_ELEMENT_PARAMS                                                              \
    __global const uint *cell_divisions, /* (n_patches, 2)                          */ \
    __global const uint *side_first_cell, /* (n_patches, 2) HR_NONE: no light there */ \
    __global const uint *cell_row,       /* (n_cells,)                              */ \
    __global const uint *cell_side,      /* (n_cells,) 2 patch + side               */ \
    __global const uint *row_start,      /* (n_rows + 1,) into row_cell             */ \
    __global const uint *row_cell,       /* (n_cells,) cells of row 0, of row 1, …  */ \
    __global const float *row_share      /* (n_cells,) summed share of the row's area up to this cell */
#define HR_ELEMENT cell_divisions, side_first_cell, cell_row, cell_side, row_start, row_cell, row_share

/* Cell of the point (u, v) of a patch side, HR_NONE where there is no light. */
HR_FORCE_INLINE uint hr_cell_at(const uint patch, const uint side, const float u, const float v,
                       __global const uint *cell_divisions, __global const uint *side_first_cell,
                       __global const uint *patch_kind)
{
    const uint first = side_first_cell[2 * patch + side];
    if (first == HR_NONE)
        return HR_NONE;
    const uint nu = cell_divisions[2 * patch];
    const uint nv = cell_divisions[2 * patch + 1];
    const float fu = hr_smaller(hr_larger(u * (float)nu, 0.0f), (float)nu - 0.5f);
    const float fv = hr_smaller(hr_larger(v * (float)nv, 0.0f), (float)nv - 0.5f);
    const uint iu = (uint)fu;
    const uint iv = (uint)fv;
    if (!patch_kind[patch])
        return first + iu + nu * iv;
    const uint a = min(iu, nu - 1 - iv);
    const uint left = nu - iv;
    const uint upper = (a + 1 < left && (fu - (float)a) + (fv - (float)iv) > 1.0f) ? 1 : 0;
    return first + nu * nu - left * left + 2 * a + upper;
}

/* (u, v) on the patch of a point (s, t) of the unit square that is spread evenly over one cell. */
HR_FORCE_INLINE float2 hr_cell_point(const uint cell, const float s, const float t, __global const uint *cell_divisions,
                            __global const uint *side_first_cell, __global const uint *cell_side,
                            __global const uint *patch_kind)
{
    const uint patch = cell_side[cell] >> 1;
    const uint local_id = cell - side_first_cell[cell_side[cell]];
    const uint nu = cell_divisions[2 * patch];
    const uint nv = cell_divisions[2 * patch + 1];
    if (!patch_kind[patch])
        return (float2)(((float)(local_id % nu) + s) / (float)nu, ((float)(local_id / nu) + t) / (float)nv);
    const uint from_end = nu * nu - 1 - local_id;
    uint m = (uint)sqrt((float)from_end);
    m = m * m > from_end ? m - 1 : (m + 1) * (m + 1) <= from_end ? m + 1 : m;
    const uint b = nu - 1 - m;
    const uint position = local_id - (nu * nu - (m + 1) * (m + 1));
    const float2 inside = hr_square_to_triangle(s, t);
    const float2 corner = (float2)((float)(position >> 1), (float)b);
    const float2 uv = (position & 1u) ? corner + (float2)(1.0f) - inside : corner + inside;
    return uv / (float)nu;
}

/* A point on a row element: its cell by share of area, then its place in the cell. */
typedef struct {
    uint patch;
    uint side;
    float3 position;
    float3 normal;
} hr_place;

HR_FORCE_INLINE hr_place hr_place_on_row(const uint row, const float s, const float t, HR_ELEMENT_PARAMS, HR_PATCH_PARAMS)
{
    uint low = row_start[row];
    uint high = row_start[row + 1] - 1;
    while (low < high) {
        const uint middle = (low + high) / 2;
        if (s < row_share[middle])
            high = middle;
        else
            low = middle + 1;
    }
    const float from = low > row_start[row] ? row_share[low - 1] : 0.0f;
    const float within = hr_smaller(hr_larger((s - from) / (row_share[low] - from), 0.0f), 0.99999994f);
    const uint cell = row_cell[low];
    const float2 uv = hr_cell_point(cell, within, t, cell_divisions, side_first_cell, cell_side, patch_kind);
    hr_place place;
    place.patch = cell_side[cell] >> 1;
    place.side = cell_side[cell] & 1u;
    place.position = hr_patch_point(place.patch, uv.x, uv.y, HR_PATCH);
    place.normal = hr_side_normal(place.patch, place.side, patch_normal);
    return place;
}

#endif
