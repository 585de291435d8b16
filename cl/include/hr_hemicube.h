/* Hemicube: patches drawn on the five faces of half a cube over a point, the nearest one kept for each pixel.
   Cohen & Greenberg 1985. Needs double: in single precision large patches beside the point lose up to 6 % of its
   view. */
#ifndef HR_HEMICUBE_H
#define HR_HEMICUBE_H

#pragma OPENCL EXTENSION cl_khr_fp64 : enable

#include "include/hr_elements.h"
#include "include/hr_outcomes.h"

/* Patches in double precision: their own arrays, since float corners of neighbours leave gaps. */
#define HR_DRAWN_PARAMS                                                                         \
    __global const double *drawn_origin, /* (n_patches, 3) [m], local frame                  */ \
    __global const double *drawn_edge_u, /* (n_patches, 3) [m]                               */ \
    __global const double *drawn_edge_v, /* (n_patches, 3) [m]                               */ \
    __global const double *drawn_sphere, /* (n_patches, 4) centre and radius around it [m]   */ \
    __global const uint *patch_kind      /* (n_patches,) 1 = a triangle                      */
#define HR_DRAWN drawn_origin, drawn_edge_u, drawn_edge_v, drawn_sphere, patch_kind

#define HR_HEMICUBE_FACES 5u
/* Outcomes are counted behind the items, in the order miss, sky, covered, unlit. */
#define HR_OUTCOME_SLOT(outcome) (HR_NONE - (outcome))

/* Axes of a face, right-handed: a pixel at (x, y) looks along x right + y up + ahead. */
typedef struct {
    double3 right;
    double3 up;
    double3 ahead;
} hr_face;

inline double3 hr_load3d(__global const double *rows, const uint i)
{
    return vload3(i, rows);
}

/* Face 0 looks along the normal, 1 to 4 along the tangents; these have "up" along the normal, and only their upper
   half (y > 0) is above the horizon. n: unit normal; the frame is turned about it by `angle`. */
inline hr_face hr_hemicube_face(const double3 n, const double angle, const uint face)
{
    const double sign = n.z >= 0.0 ? 1.0 : -1.0;
    const double a = -1.0 / (sign + n.z);
    const double c = n.x * n.y * a;
    const double3 t0 = (double3)(1.0 + sign * n.x * n.x * a, sign * c, -sign * n.x);
    const double3 b0 = (double3)(c, sign + n.y * n.y * a, -n.y);
    const double cosine = cos(angle), sine = sin(angle);
    const double3 t = cosine * t0 + sine * b0;
    const double3 b = cosine * b0 - sine * t0;
    hr_face axes;
    if (face == 0) {
        axes.right = t;
        axes.up = b;
        axes.ahead = n;
        return axes;
    }
    axes.ahead = face == 1 ? t : face == 2 ? b : face == 3 ? -t : -b;
    axes.right = face == 1 ? b : face == 2 ? -t : face == 3 ? -b : t;
    axes.up = n;
    return axes;
}

/* A patch as seen from the point, in the frame of a face. Along the ray (x, y, 1) times s, with d = (x, y, 1):
   u = U.d / W.d, v = V.d / W.d, 1/s = inverse . d. All are ratios of linear functions, so that nothing has to be
   clipped: rasterisation in homogeneous coordinates, Olano & Greer 1997. */
typedef struct {
    double3 u;
    double3 v;
    double3 w;
    double3 inverse;
    uint side; /* that looks at the point: 0 front, 1 back */
    int seen;  /* 0 when the point lies in the patch's plane */
} hr_projection;

inline double3 hr_in_frame(const double3 p, const hr_face axes)
{
    return (double3)(dot(p, axes.right), dot(p, axes.up), dot(p, axes.ahead));
}

inline hr_projection hr_project(const double3 eye, const uint patch, const hr_face axes, HR_DRAWN_PARAMS)
{
    const double3 r = hr_in_frame(hr_load3d(drawn_origin, patch) - eye, axes);
    const double3 eu = hr_in_frame(hr_load3d(drawn_edge_u, patch), axes);
    const double3 ev = hr_in_frame(hr_load3d(drawn_edge_v, patch), axes);
    const double3 w = cross(eu, ev);
    const double height = dot(w, r);
    const double towards = height > 0.0 ? 1.0 : -1.0;
    hr_projection p;
    p.u = towards * cross(ev, r);
    p.v = towards * cross(r, eu);
    p.w = towards * w;
    p.seen = fabs(height) > 0.0;
    p.inverse = p.seen ? p.w / fabs(height) : (double3)(0.0);
    p.side = height < 0.0 ? 0u : 1u;
    return p;
}

/* Narrows the interval of x in which c.(x, y, 1) >= 0. */
inline void hr_narrow(const double3 c, const double y, double *low, double *high)
{
    const double at_zero = c.y * y + c.z;
    if (c.x > 0.0)
        *low = fmax(*low, -at_zero / c.x);
    else if (c.x < 0.0)
        *high = fmin(*high, -at_zero / c.x);
    else if (at_zero < 0.0)
        *high = -INFINITY;
}

/* 1 when a sphere (centre in the frame of the face) has no part inside |x| <= z, y0 z <= y <= y1 z. */
inline int hr_sphere_outside(const double3 c, const double radius, const double y0, const double y1)
{
    if (fabs(c.x) - c.z > 1.4142135623730951 * radius)
        return 1;
    if (c.y - y1 * c.z > radius * sqrt(1.0 + y1 * y1))
        return 1;
    return y0 * c.z - c.y > radius * sqrt(1.0 + y0 * y0);
}

/* Lowest and highest y of the patch on the face; the whole range when it reaches behind the point. */
inline double2 hr_projected_heights(const double3 eye, const uint patch, const hr_face axes, HR_DRAWN_PARAMS)
{
    const double3 r = hr_in_frame(hr_load3d(drawn_origin, patch) - eye, axes);
    const double3 eu = hr_in_frame(hr_load3d(drawn_edge_u, patch), axes);
    const double3 ev = hr_in_frame(hr_load3d(drawn_edge_v, patch), axes);
    const double3 corner[4] = {r, r + eu, r + ev, patch_kind[patch] ? r : r + eu + ev};
    double low = INFINITY, high = -INFINITY;
    for (uint k = 0; k < 4; ++k) {
        if (!(corner[k].z > 0.0))
            return (double2)(-INFINITY, INFINITY);
        low = fmin(low, corner[k].y / corner[k].z);
        high = fmax(high, corner[k].y / corner[k].z);
    }
    return (double2)(low, high);
}

/* Draws one patch into rows [first, last) of a face with `width` pixels a row; rows lie `y0 + (row + 0.5) step` high
   and pixels the same way from x = -1 on. Ties go to the patch drawn first. */
inline void hr_draw_patch(const hr_projection p, const uint patch, const uint triangle, const double2 heights,
                          const double y0, const double step, const uint width, const uint first, const uint last,
                          __global float *depth, __global uint *drawn)
{
    const double3 far_u = triangle ? p.w - p.u - p.v : p.w - p.u;
    const double3 far_v = triangle ? p.w : p.w - p.v;
    const double per_row = 1.0 / step;
    const int from = (int)fmax((double)first, ceil((heights.x - y0) * per_row - 0.5));
    const int to = (int)fmin((double)last - 1.0, floor((heights.y - y0) * per_row - 0.5));
    for (int row = from; row <= to; ++row) {
        const double y = y0 + ((double)row + 0.5) * step;
        double low = -1.0, high = 1.0;
        hr_narrow(p.u, y, &low, &high);
        hr_narrow(p.v, y, &low, &high);
        hr_narrow(far_u, y, &low, &high);
        hr_narrow(far_v, y, &low, &high);
        if (!(low <= high))
            continue;
        const int left = (int)fmax(0.0, ceil((low + 1.0) * per_row - 0.5));
        const int right = (int)fmin((double)width - 1.0, floor((high + 1.0) * per_row - 0.5));
        const float slope = (float)(p.inverse.x * step);
        const float start = (float)(p.inverse.x * (0.5 * step - 1.0) + p.inverse.y * y + p.inverse.z);
        __global float *depth_row = depth + (size_t)row * width;
        __global uint *drawn_row = drawn + (size_t)row * width;
        for (int x = left; x <= right; ++x) {
            const float inverse = start + slope * (float)x;
            const int nearer = inverse > depth_row[x];
            depth_row[x] = nearer ? inverse : depth_row[x];
            drawn_row[x] = nearer ? patch : drawn_row[x];
        }
    }
}

/* Replaces the patch drawn in each pixel by its item, or by the slot of the outcome. Neighbours show the same patch
   mostly, so it is projected once for each run of pixels. */
inline void hr_name_pixels(const double3 eye, const hr_face axes, HR_DRAWN_PARAMS,
                           __global const uint *cell_divisions, __global const uint *side_first_cell,
                           __global const uint *cell_item, __global const uint *patch_solid, const double y0,
                           const double step, const uint width, const uint first, const uint last,
                           const uint n_things, __global uint *item)
{
    for (uint row = first; row < last; ++row) {
        const double y = y0 + ((double)row + 0.5) * step;
        uint patch = HR_NONE;
        hr_projection p;
        for (uint column = 0; column < width; ++column) {
            const size_t k = (size_t)row * width + column;
            const double x = ((double)column + 0.5) * step - 1.0;
            const uint drawn = item[k];
            if (drawn == HR_NONE) {
                const double upward = x * axes.right.z + y * axes.up.z + axes.ahead.z;
                item[k] = n_things + HR_OUTCOME_SLOT(upward > 0.0 ? HR_SKY : HR_MISS);
                continue;
            }
            if (drawn != patch) {
                patch = drawn;
                p = hr_project(eye, patch, axes, HR_DRAWN);
            }
            if (p.side == HR_BACK && patch_solid[patch]) {
                item[k] = n_things + HR_OUTCOME_SLOT(HR_COVERED);
                continue;
            }
            const double scale = 1.0 / (p.w.x * x + p.w.y * y + p.w.z);
            const float u = (float)((p.u.x * x + p.u.y * y + p.u.z) * scale);
            const float v = (float)((p.v.x * x + p.v.y * y + p.v.z) * scale);
            const uint cell = hr_cell_at(patch, p.side, u, v, cell_divisions, side_first_cell, patch_kind);
            item[k] = cell == HR_NONE ? n_things + HR_OUTCOME_SLOT(HR_UNLIT) : cell_item[cell];
        }
    }
}

#endif
