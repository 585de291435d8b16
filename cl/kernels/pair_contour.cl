/* Exchange of polygon pairs by the contour integral. */
#include "include/hr_flat_contour.h"
#include "include/hr_polygon_pair.h"

__kernel void contour_exchange(HR_POLYGON_PARAMS,
                               __global const uint *first,         /* (n_items,)                              */
                               __global const uint *second,        /* (n_items,)                              */
                               __global const double *rule_node,   /* (n_near + n_far + n_fine,) in [0, 1/2]  */
                               __global const double *rule_weight, /* (n_near + n_far + n_fine,)              */
                               const uint n_near, const uint n_far, const uint n_fine, const double near_error,
                               const double coarser_weight, const double crowded_error,
                               __global double *exchange, /* (n_items,) A F [m^2] */
                               __global double *error,    /* (n_items,) [m^2]     */
                               __global double *rounding, /* (n_items,) [m^2]     */
                               const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    double3 a[HR_CUT_CORNERS], b[HR_CUT_CORNERS];
    uint count_a, count_b;
    const double length = hr_load_facing(first[i], second[i], a, &count_a, b, &count_b, HR_POLYGON);
    const hr_rules rules = {rule_node, rule_weight, n_near, n_far, n_fine, near_error, coarser_weight, crowded_error};
    double doubt = 0.0, lost = 0.0;
    const double sum = count_a ? hr_contour_exchange(a, count_a, b, count_b, rules, &doubt, &lost) : 0.0;
    exchange[i] = sum * length * length;
    error[i] = doubt * length * length;
    rounding[i] = lost * length * length;
}

/* The same for pairs whose normals differ by less than a right angle, with the digits that the plain sum loses where
   they lie nearly in one plane. */
__kernel void flat_exchange(HR_POLYGON_PARAMS,
                            __global const uint *first,         /* (n_items,)                              */
                            __global const uint *second,        /* (n_items,)                              */
                            __global const double *rule_node,   /* (n_near + n_far + n_fine,) in [0, 1/2]  */
                            __global const double *rule_weight, /* (n_near + n_far + n_fine,)              */
                            const uint n_near, const uint n_far, const uint n_fine, const double near_error,
                            const double coarser_weight, const double crowded_error,
                            __global double *exchange, /* (n_items,) A F [m^2] */
                            __global double *error,    /* (n_items,) [m^2]     */
                            __global double *rounding, /* (n_items,) [m^2]     */
                            const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    double3 a[HR_CUT_CORNERS], b[HR_CUT_CORNERS];
    uint count_a, count_b;
    const double length = hr_load_facing(first[i], second[i], a, &count_a, b, &count_b, HR_POLYGON);
    const hr_rules rules = {rule_node, rule_weight, n_near, n_far, n_fine, near_error, coarser_weight, crowded_error};
    const double3 na = hr_row_d(polygon_normal, first[i]), nb = hr_row_d(polygon_normal, second[i]);
    double doubt = 0.0, lost = 0.0;
    const double sum =
        count_a ? hr_flat_contour_exchange(a, count_a, na, b, count_b, nb, rules, &doubt, &lost) : 0.0;
    exchange[i] = sum * length * length;
    error[i] = doubt * length * length;
    rounding[i] = lost * length * length;
}
