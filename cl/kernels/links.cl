/* Links between nodes of element hierarchies: where they are fine enough, and how much of each is open. */
#include "include/hr_covered.h"
#include "include/hr_form_factor.h"
#include "include/hr_nodes.h"

/* Samples beyond n_samples that are drawn while all lay behind a horizon. */
#define HR_LINK_PATIENCE 16u

/* What becomes of each pair: dropped where one lies behind the other, linked where the larger form factor is at most
   `most`, else the larger node is split, or the smaller one where the larger is a leaf. */
__kernel void judge_links(HR_NODE_PARAMS,
                          __global const uint *pair_first,  /* (n_items,)                                  */
                          __global const uint *pair_second, /* (n_items,)                                  */
                          __global uchar *decision,         /* (n_items,) HR_LINK_…                        */
                          __global float *factor,           /* (n_items,) of the larger, from above [1]    */
                          const uint n_leaves, const float most, const float flat, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint p = pair_first[i], q = pair_second[i];
    const float area_p = node_area[p], area_q = node_area[q];
    const float large = hr_larger(area_p, area_q), small = hr_smaller(area_p, area_q);
    const float larger_factor = hr_node_factor(p, q, large, flat, HR_NODE);
    factor[i] = larger_factor;
    if (larger_factor < 0.0f) {
        decision[i] = HR_LINK_DROP;
        return;
    }
    const int first_is_larger = area_p >= area_q;
    const int larger_splits = (first_is_larger ? p : q) >= n_leaves;
    const int smaller_splits = (first_is_larger ? q : p) >= n_leaves;
    uint verdict = HR_LINK_KEEP;
    if (larger_factor > most && larger_splits)
        verdict = first_is_larger ? HR_LINK_SPLIT_FIRST : HR_LINK_SPLIT_SECOND;
    else if (larger_factor * small > most * large && smaller_splits)
        verdict = first_is_larger ? HR_LINK_SPLIT_SECOND : HR_LINK_SPLIT_FIRST;
    decision[i] = (uchar)verdict;
}

/* Is the way from x to y free, with light at both ends? Inside a solid that stands in a corner, two covered places see
   each other past faces that lie in theirs. */
HR_FORCE_INLINE int hr_is_open(const hr_node_point *x, const hr_node_point *y, const float scale,
                               __global const float *patch_normal, HR_SOLID_PARAMS, HR_BVH_PARAMS)
{
    const float3 origin = hr_offset_origin(x->position, x->normal, scale);
    const float3 way = y->position - origin;
    if (hr_any_hit(HR_BVH, origin, way, 1.0f, x->side >> 1, y->side >> 1))
        return 0;
    const float length = sqrt(hr_dot(way, way));
    hr_hit hit;
    hit.patch = y->side >> 1;
    hit.side = y->side & 1u;
    hit.t = length;
    hit.u = hit.v = 0.0f;
    return !hr_leaves_solid(hit, origin, way / length, scale, patch_normal, HR_SOLID, HR_BVH);
}

/* Adds a pair of points that both of two ways of drawing may give: evenly on the areas, or along a direction with
   density cos / pi. Its weight by the balance heuristic (Veach & Guibas 1995) stays bounded however near they are. */
HR_FORCE_INLINE void hr_add_pair(const hr_node_point *x, const hr_node_point *y, const float even, const int directed,
                                 float *sum, float *seen, const float scale, __global const float *patch_normal,
                                 HR_SOLID_PARAMS, HR_BVH_PARAMS)
{
    const float density = hr_point_kernel(x->normal, y->position - x->position, y->normal);
    if (!(density > 0.0f))
        return;
    const float weight = directed ? density / (even + density) : density / even;
    *sum += weight;
    *seen += hr_is_open(x, y, scale, patch_normal, HR_SOLID, HR_BVH) ? weight : 0.0f;
}

/* Sums of cos cos / (pi r^2) over random pairs of points of two nodes, all of them and those in sight of each other, in
   units that cancel. Points of nodes whose form factor is at least `near` are also drawn along directions: of plates a
   finger apart, evenly drawn points hardly ever lie opposite each other. */
__kernel void sample_links(HR_BVH_PARAMS, HR_NODE_PARAMS, HR_SOLID_PARAMS,
                           __global const float *patch_normal, /* (n_patches, 3) unit */
                           __global const uint *link_first,    /* (n_items,)          */
                           __global const uint *link_second,   /* (n_items,)          */
                           __global const float *factor,       /* (n_items,) from judge_links */
                           __global const uint *n_samples,     /* (n_items,)          */
                           __global float *total,              /* (n_items,)          */
                           __global float *open,               /* (n_items,)          */
                           const float near, const uint seed, const float scale, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const int swapped = node_area[link_first[i]] > node_area[link_second[i]];
    const uint p = swapped ? link_second[i] : link_first[i];
    const uint q = swapped ? link_first[i] : link_second[i];
    const uint key = hr_combine(hr_combine(seed, p), q);
    const int directed = factor[i] >= near;
    const float even = 1.0f / node_area[q];
    const uint wanted = n_samples[i];
    float sum = 0.0f, seen = 0.0f;
    for (uint k = 0; k < wanted || (sum == 0.0f && k < wanted + HR_LINK_PATIENCE); ++k) {
        hr_node_point x, y;
        hr_point_of_node(p, hr_sample(k, 0, key), hr_sample(k, 1, key), &x, HR_NODE);
        const float s = hr_sample(k, 2, key), t = hr_sample(k, 3, key);
        hr_point_of_node(q, s, t, &y, HR_NODE);
        hr_add_pair(&x, &y, even, directed, &sum, &seen, scale, patch_normal, HR_SOLID, HR_BVH);
        if (!directed)
            continue;
        const float3 d = hr_cosine_direction(x.normal, s, t);
        for (uint facet = node_facet[q]; facet < node_facet[q + 1]; ++facet) {
            const float length = hr_meets_facet(x.position, d, facet, HR_NODE);
            y.position = x.position + length * d;
            y.normal = hr_load3(facet_normal, facet);
            y.side = facet_side[facet];
            if (length > 0.0f)
                hr_add_pair(&x, &y, even, 1, &sum, &seen, scale, patch_normal, HR_SOLID, HR_BVH);
        }
    }
    total[i] = sum;
    open[i] = seen;
}
