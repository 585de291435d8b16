/* Nodes of element hierarchies as sets of flat facets: what two of them see of each other, and points on them. */
#ifndef HR_NODES_H
#define HR_NODES_H

#include "include/hr_patches.h"
#include "include/hr_sampling.h"

#define HR_NODE_PARAMS                                                                            \
    __global const uint *node_facet,    /* (n_nodes + 1,) first facet of each                  */ \
    __global const float *node_area,    /* (n_nodes,) [m^2]                                    */ \
    __global const float *node_sphere,  /* (n_nodes, 4) centre [m], local, and radius [m]      */ \
    __global const float *facet_corner, /* (n_facets, 4, 3) [m], counter-clockwise, local      */ \
    __global const float *facet_normal, /* (n_facets, 3) unit, of the lit side                 */ \
    __global const float *facet_share,  /* (n_facets,) summed share of the node's area         */ \
    __global const uint *facet_kind,    /* (n_facets,) 1 = a triangle                          */ \
    __global const uint *facet_side     /* (n_facets,) 2 patch + side                          */
#define HR_NODE node_facet, node_area, node_sphere, facet_corner, facet_normal, facet_share, facet_kind, facet_side

#define HR_LINK_DROP 0u
#define HR_LINK_KEEP 1u
#define HR_LINK_SPLIT_FIRST 2u
#define HR_LINK_SPLIT_SECOND 3u

typedef struct {
    float3 point[5]; /* centre, then corners */
    float3 normal;
} hr_facet;

HR_FORCE_INLINE void hr_load_facet(const uint facet, hr_facet *f, HR_NODE_PARAMS)
{
    for (uint k = 0; k < 4u; ++k)
        f->point[1u + k] = hr_load3(facet_corner, 4u * facet + k);
    f->point[0] = facet_kind[facet] ? (f->point[1] + f->point[2] + f->point[3]) * 0.33333333f
                                    : 0.5f * (f->point[1] + f->point[3]);
    f->normal = hr_load3(facet_normal, facet);
}

/* Does any corner of g rise more than `flat` over the plane of f? */
HR_FORCE_INLINE int hr_rises(const hr_facet *g, const hr_facet *f, const float flat)
{
    int found = 0;
    for (uint k = 1; k < 5u; ++k)
        found |= hr_dot(f->normal, g->point[k] - f->point[0]) > flat;
    return found;
}

/* cos cos / (pi r^2 + area): times `area`, what a point sees of a disk of that area (Hanrahan et al. 1991, eq. 3). */
HR_FORCE_INLINE float hr_disk_factor(const float3 x, const float3 n, const float3 y, const float3 m, const float area)
{
    const float3 d = y - x;
    const float r2 = hr_dot(d, d);
    const float a = hr_dot(n, d), b = -hr_dot(m, d);
    return a > 0.0f && b > 0.0f ? a * b / (r2 * (HR_PI * r2 + area)) : 0.0f;
}

/* Largest of these between the centre of one facet and centre or corners of the other; between corners where the
   centres see nothing. */
HR_FORCE_INLINE float hr_facet_factor(const hr_facet *f, const hr_facet *g, const float area)
{
    float most = 0.0f;
    for (uint k = 0; k < 5u; ++k) {
        most = hr_larger(most, hr_disk_factor(f->point[0], f->normal, g->point[k], g->normal, area));
        most = hr_larger(most, hr_disk_factor(f->point[k], f->normal, g->point[0], g->normal, area));
    }
    for (uint k = 0; k < 16u && most == 0.0f; ++k)
        most = hr_disk_factor(f->point[1u + k / 4u], f->normal, g->point[1u + k % 4u], g->normal, area);
    return most;
}

/* Whether the spheres about both nodes overlap. */
HR_FORCE_INLINE int hr_is_close(const uint p, const uint q, __global const float *node_sphere)
{
    const float4 a = ((__global const float4 *)node_sphere)[p];
    const float4 b = ((__global const float4 *)node_sphere)[q];
    const float3 d = (float3)(b.x - a.x, b.y - a.y, b.z - a.z);
    const float reach = a.w + b.w;
    return hr_dot(d, d) < reach * reach;
}

/* Estimate of the form factor of a node of that `area` from a point of the other, from above; negative if every facet
   of one lies behind all facets of the other. Between nodes that are close, single points tell nothing: plates a
   finger apart see all of each other, though hardly any centre sees a corner. [1] */
HR_FORCE_INLINE float hr_node_factor(const uint p, const uint q, const float area, const float flat, HR_NODE_PARAMS)
{
    float most = -1.0f;
    const int is_close = hr_is_close(p, q, node_sphere);
    for (uint i = node_facet[p]; i < node_facet[p + 1]; ++i) {
        hr_facet f;
        hr_load_facet(i, &f, HR_NODE);
        for (uint j = node_facet[q]; j < node_facet[q + 1]; ++j) {
            hr_facet g;
            hr_load_facet(j, &g, HR_NODE);
            if (hr_rises(&g, &f, flat) && hr_rises(&f, &g, flat))
                most = hr_larger(most, is_close ? 1.0f : area * hr_facet_factor(&f, &g, area));
        }
    }
    return most;
}

/* A point of a node: its facet by share of area, then its place there. */
typedef struct {
    float3 position;
    float3 normal;
    uint side; /* 2 patch + side */
} hr_node_point;

HR_FORCE_INLINE void hr_point_of_node(const uint node, const float s, const float t, hr_node_point *place,
                                      HR_NODE_PARAMS)
{
    uint facet = node_facet[node];
    while (facet + 1u < node_facet[node + 1] && s >= facet_share[facet])
        ++facet;
    const float from = facet > node_facet[node] ? facet_share[facet - 1u] : 0.0f;
    float2 at = (float2)(hr_smaller((s - from) / (facet_share[facet] - from), 0.99999994f), t);
    if (facet_kind[facet])
        at = hr_square_to_triangle(at.x, at.y);
    const float3 corner = hr_load3(facet_corner, 4u * facet);
    place->position = corner + at.x * (hr_load3(facet_corner, 4u * facet + 1u) - corner) +
                      at.y * (hr_load3(facet_corner, 4u * facet + 3u) - corner);
    place->normal = hr_load3(facet_normal, facet);
    place->side = facet_side[facet];
}

/* Where the ray from x along d meets the lit side of a facet, in lengths of d; 0 where it doesn't. */
HR_FORCE_INLINE float hr_meets_facet(const float3 x, const float3 d, const uint facet, HR_NODE_PARAMS)
{
    const float3 n = hr_load3(facet_normal, facet);
    const float3 r = hr_load3(facet_corner, 4u * facet) - x;
    const float along = hr_dot(n, d), height = hr_dot(n, r);
    if (along >= 0.0f || height >= 0.0f)
        return 0.0f;
    const float t = height / along;
    const float3 at = t * d - r;
    const float3 eu = hr_load3(facet_corner, 4u * facet + 1u) - hr_load3(facet_corner, 4u * facet);
    const float3 ev = hr_load3(facet_corner, 4u * facet + 3u) - hr_load3(facet_corner, 4u * facet);
    const float3 across = hr_cross(eu, ev);
    const float per = 1.0f / hr_dot(across, across);
    const float u = hr_dot(hr_cross(at, ev), across) * per, v = hr_dot(hr_cross(eu, at), across) * per;
    const int inside = u >= 0.0f && v >= 0.0f && (facet_kind[facet] ? u + v <= 1.0f : u <= 1.0f && v <= 1.0f);
    return inside ? t : 0.0f;
}

#endif
