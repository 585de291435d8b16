/* Item buffers of hemicubes, and the form factors that their pixels add up to. */
#include "include/hr_hemicube.h"

/* One work-item draws a strip of one face: all patches, then the item of each pixel. Buffers of one point: the top
   face with resolution^2 pixels, then the upper halves of the four sides. */
__kernel void draw_hemicubes(HR_DRAWN_PARAMS,
                             __global const uint *cell_divisions,  /* (n_patches, 2)                     */
                             __global const uint *side_first_cell, /* (n_patches, 2)                     */
                             __global const uint *cell_item,       /* (n_cells,)                         */
                             __global const uint *patch_solid,     /* (n_patches,) not 0: matter behind  */
                             __global const double *eye,           /* (n_points, 3) [m], local frame     */
                             __global const double *normal,        /* (n_points, 3) unit                 */
                             __global const double *angle,         /* (n_points,) turn about the normal  */
                             __global const uint *own_patch,       /* (n_points,) not drawn, or HR_NONE  */
                             __global float *depth,                /* (n_points, 3 resolution^2) [m^-1]  */
                             __global uint *item,                  /* (n_points, 3 resolution^2)         */
                             const uint n_patches, const uint n_things, const uint resolution,
                             const uint n_strips, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint point = i / (HR_HEMICUBE_FACES * n_strips);
    const uint face = i / n_strips % HR_HEMICUBE_FACES;
    const uint strip = i % n_strips;
    const uint rows = face == 0 ? resolution : resolution / 2;
    const uint first = rows * strip / n_strips;
    const uint last = rows * (strip + 1) / n_strips;
    const size_t pixels = (size_t)resolution * resolution;
    const size_t place = (size_t)point * 3 * pixels + (face == 0 ? 0 : pixels + (face - 1) * (pixels / 2));
    __global float *face_depth = depth + place;
    __global uint *face_item = item + place;
    for (size_t k = (size_t)first * resolution; k < (size_t)last * resolution; ++k) {
        face_depth[k] = 0.0f;
        face_item[k] = HR_NONE;
    }
    const double3 x = hr_load3d(eye, point);
    const hr_face axes = hr_hemicube_face(hr_load3d(normal, point), angle[point], face);
    const double step = 2.0 / (double)resolution;
    const double y0 = face == 0 ? -1.0 : 0.0;
    const double bottom = y0 + (double)first * step;
    const double top = y0 + (double)last * step;
    for (uint patch = 0; patch < n_patches; ++patch) {
        const double4 sphere = vload4(patch, drawn_sphere);
        if (patch == own_patch[point] || hr_sphere_outside(hr_in_frame(sphere.xyz - x, axes), sphere.w, bottom, top))
            continue;
        const hr_projection p = hr_project(x, patch, axes, HR_DRAWN);
        if (p.seen)
            hr_draw_patch(p, patch, patch_kind[patch], hr_projected_heights(x, patch, axes, HR_DRAWN), y0, step,
                          resolution, first, last, face_depth, face_item);
    }
    hr_name_pixels(x, axes, HR_DRAWN, cell_divisions, side_first_cell, cell_item, patch_solid, y0, step, resolution,
                   first, last, n_things, face_item);
}

/* Adds up the pixels of each item; one work-group a point, whose first work-item does it in a fixed order. */
__kernel void add_pixels(__global const uint *item,    /* (n_points, 3 resolution^2)                             */
                         __global const float *weight, /* (1.5 resolution^2,) delta factors of top and one side  */
                         __global float *factor,       /* (n_points, n_columns)                                  */
                         const uint resolution, const uint n_columns, const uint n_items)
{
    if (get_local_id(0) != 0 || get_global_id(0) >= n_items)
        return;
    const size_t point = get_group_id(0);
    const size_t pixels = (size_t)resolution * resolution;
    __global const uint *seen = item + point * 3 * pixels;
    __global float *row = factor + point * n_columns;
    for (uint c = 0; c < n_columns; ++c)
        row[c] = 0.0f;
    for (uint face = 0; face < HR_HEMICUBE_FACES; ++face) {
        const size_t begin = face == 0 ? 0 : pixels + (face - 1) * (pixels / 2);
        const size_t count = face == 0 ? pixels : pixels / 2;
        __global const float *delta = face == 0 ? weight : weight + pixels;
        uint current = seen[begin];
        double sum = 0.0;
        for (size_t k = 0; k < count; ++k) {
            const uint next = seen[begin + k];
            if (next != current) {
                row[current] += (float)sum;
                sum = 0.0;
                current = next;
            }
            sum += (double)delta[k];
        }
        row[current] += (float)sum;
    }
}
