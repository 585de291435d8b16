/* Exchange of two polygons as a double integral over their contours (Stokes):
   A F = 1/(2 pi) | sum over edges a, b of (u_a . u_b) * integral integral ln|p - q| dp dq |.
   One integral is closed (Mitalas & Stephenson 1966); the other one is closed for parallel edges, else by quadrature
   that crowds points where the edges come near each other. */
#ifndef HR_CONTOUR_H
#define HR_CONTOUR_H

#include "include/hr_double.h"

/* Sine of the angle below which edges count as parallel. */
#define HR_PARALLEL 1.0e-12

/* Nodes in [0, 1/2] of rules on [0, 1] that are symmetric about the middle, with weights. */
typedef struct {
    __global const double *node;
    __global const double *weight;
    uint n_near; /* nodes of the rule for edges at least half a length apart, first in the arrays */
    uint n_far;  /* nodes of the rule for edges further apart than 1.5 lengths, next */
    uint n_fine; /* nodes of the double-exponential rule, next; every second one belongs to the coarser one */
    double near_error; /* relative error of the first two rules */
} hr_rules;

/* integral of ln|p - q| dq over the edge from q0 along the unit vector v. */
HR_FORCE_INLINE double hr_log_integral(const double3 p, const double3 q0, const double3 v, const double length)
{
    const double3 r = q0 - p;
    const double t = hr_dot_d(r, v);
    const double3 off = hr_cross_d(r, v);
    const double h2 = hr_dot_d(off, off);
    const double h = sqrt(h2);
    const double start2 = h2 + t * t;
    const double end = t + length;
    const double end2 = h2 + end * end;
    if (t > 0.0 || end < 0.0) {
        /* The foot lies beside the edge: the difference of logarithms as one, which keeps its digits far away. The
           nearer end is the one that the logarithm is taken at. */
        const double near2 = t > 0.0 ? start2 : end2;
        const double near = t > 0.0 ? t : -end;
        const double far = near + length;
        if (near2 > 0.0)
            return 0.5 * (length * log(near2) + far * log1p(length * (near + far) / near2)) - length +
                   h * atan2(length * h, h2 + t * end);
    }
    double sum = h > 0.0 ? h * atan2(length * h, h2 + t * end) : 0.0;
    sum += end2 > 0.0 ? 0.5 * end * log(end2) : 0.0;
    sum -= start2 > 0.0 ? 0.5 * t * log(start2) : 0.0;
    return sum - length;
}

/* Second antiderivative in x of ln(x^2 + h^2) / 2. */
HR_FORCE_INLINE double hr_log_primitive(const double x, const double h)
{
    const double r2 = x * x + h * h;
    if (r2 == 0.0)
        return 0.0;
    return 0.25 * (x * x - h * h) * log(r2) + h * x * atan2(x, h) - 0.75 * x * x;
}

/* integral integral ln|p - q| dp dq over parallel edges: p0 + s u, s < length_a; the other one starts x further along
   u, at distance h, and is followed along u (length_b). */
HR_FORCE_INLINE double hr_parallel_edges(const double x, const double h, const double length_a, const double length_b)
{
    return (hr_log_primitive(x + length_b, h) - hr_log_primitive(x, h)) -
           (hr_log_primitive(x + length_b - length_a, h) - hr_log_primitive(x - length_a, h));
}

/* Smallest squared distance of two edges: Ericson, "Real-Time Collision Detection" (2005), 5.1.9, for edges with
   length. *s: place of the closest point of the first edge's line to the second line [length along u]. */
HR_FORCE_INLINE double hr_edge_distance2(const double3 p0, const double3 u, const double length_a, const double3 q0,
                                         const double3 v, const double length_b, double *s)
{
    const double3 r = p0 - q0;
    const double b = hr_dot_d(u, v);
    const double c = hr_dot_d(u, r);
    const double f = hr_dot_d(v, r);
    const double squared_sine = hr_larger_d(1.0 - b * b, 1.0e-30);
    const double across = (b * f - c) / squared_sine;
    *s = across;
    double on_a = across < 0.0 ? 0.0 : across > length_a ? length_a : across;
    double on_b = b * on_a + f;
    on_b = on_b < 0.0 ? 0.0 : on_b > length_b ? length_b : on_b;
    on_a = b * on_b - c;
    on_a = on_a < 0.0 ? 0.0 : on_a > length_a ? length_a : on_a;
    const double3 gap = r + on_a * u - on_b * v;
    return hr_dot_d(gap, gap);
}

/* The edge from q0 along v, as seen from points p0 + s u: integral over s in [low, high], by one of the rules without
   crowding. */
inline double hr_smooth_piece(const double3 p0, const double3 u, const double length_a, const double3 q0,
                              const double3 v, const double length_b, __global const double *node,
                              __global const double *weight, const uint n)
{
    double sum = 0.0;
    for (uint k = 0; k < n; ++k) {
        const double near = length_a * node[k];
        sum += weight[k] * (hr_log_integral(p0 + near * u, q0, v, length_b) +
                            hr_log_integral(p0 + (length_a - near) * u, q0, v, length_b));
    }
    return sum * length_a;
}

/* The same by the double-exponential rule of Takahasi & Mori 1974 over [low, high]. *coarse: with half the nodes. */
inline double hr_crowded_piece(const double3 p0, const double3 u, const double low, const double high,
                               const double3 q0, const double3 v, const double length_b, const hr_rules rules,
                               double *coarse)
{
    __global const double *node = rules.node + rules.n_near + rules.n_far;
    __global const double *weight = rules.weight + rules.n_near + rules.n_far;
    const double length = high - low;
    double even = 0.0, odd = 0.0;
    for (uint k = 0; k < rules.n_fine; ++k) {
        const double near = length * node[k];
        const double both = weight[k] * (hr_log_integral(p0 + (low + near) * u, q0, v, length_b) +
                                         hr_log_integral(p0 + (high - near) * u, q0, v, length_b));
        if (k % 2 == 0)
            even += both;
        else
            odd += both;
    }
    *coarse = 2.0 * even * length;
    return (even + odd) * length;
}

/* Edges that come near each other: the first one is cut where the second one begins, ends, or is crossed. */
inline double hr_crowded_edges(const double3 p0, const double3 u, const double length_a, const double3 q0,
                               const double3 v, const double length_b, const double crossing, const hr_rules rules,
                               double *error)
{
    const double begin = hr_dot_d(q0 - p0, u);
    const double end = begin + length_b * hr_dot_d(u, v);
    double low = hr_smaller_d(begin, end), high = hr_larger_d(begin, end);
    double cut[5] = {0.0, hr_smaller_d(low, crossing), hr_larger_d(low, hr_smaller_d(high, crossing)),
                     hr_larger_d(high, crossing), length_a};
    double sum = 0.0, at = 0.0;
    *error = 0.0;
    for (uint k = 1; k < 5; ++k) {
        const double to = k == 4 || cut[k] > length_a * (1.0 - 1.0e-9) ? length_a : cut[k];
        if (to - at <= length_a * 1.0e-9)
            continue;
        double coarse;
        const double fine = hr_crowded_piece(p0, u, at, to, q0, v, length_b, rules, &coarse);
        /* Each halving of the step doubles the digits; three halves are taken as safe. */
        const double relative = hr_magnitude_d(fine - coarse) / (to - at);
        *error += (to - at) * relative * hr_smaller_d(1.0, sqrt(relative));
        sum += fine;
        at = to;
    }
    return sum;
}

/* integral integral ln|p - q| dp dq over two edges, not yet multiplied by the cosine between them. *error: estimate
   of the quadrature's error; *magnitude: size of what rounding errors are relative to. */
inline double hr_edge_pair(const double3 a0, const double3 u, const double length_a, const double3 b0, const double3 v,
                           const double length_b, const hr_rules rules, double *error, double *magnitude)
{
    const double cosine = hr_dot_d(u, v);
    const double3 normal = hr_cross_d(u, v);
    const int swapped = length_a > length_b;
    const double3 p0 = swapped ? b0 : a0, q0 = swapped ? a0 : b0;
    const double3 along = swapped ? v : u, other = swapped ? u : v;
    const double short_length = swapped ? length_b : length_a, long_length = swapped ? length_a : length_b;
    double crossing;
    const double distance2 = hr_edge_distance2(p0, along, short_length, q0, other, long_length, &crossing);
    const double short2 = short_length * short_length;
    *error = 0.0;
    double value;
    if (distance2 >= 2.25 * short2) {
        value = hr_smooth_piece(p0, along, short_length, q0, other, long_length, rules.node + rules.n_near,
                                rules.weight + rules.n_near, rules.n_far);
        *error = rules.near_error * hr_magnitude_d(value);
    } else if (hr_dot_d(normal, normal) < HR_PARALLEL * HR_PARALLEL) {
        const double3 r = q0 - p0;
        const double3 off = hr_cross_d(r, along);
        const double x = hr_dot_d(r, along) - (cosine < 0.0 ? long_length : 0.0);
        value = hr_parallel_edges(x, sqrt(hr_dot_d(off, off)), short_length, long_length);
        *magnitude += long_length * long_length;
    } else if (distance2 >= 0.25 * short2) {
        value = hr_smooth_piece(p0, along, short_length, q0, other, long_length, rules.node, rules.weight,
                                rules.n_near);
        *error = rules.near_error * hr_magnitude_d(value);
    } else {
        value = hr_crowded_edges(p0, along, short_length, q0, other, long_length, crossing, rules, error);
    }
    *magnitude += short_length * long_length;
    return value;
}

/* A F of two convex polygons that see all of each other, from corners in units of about their extent. */
inline double hr_contour_exchange(const double3 *a, const uint count_a, const double3 *b, const uint count_b,
                                  const hr_rules rules, double *error)
{
    double sum = 0.0, doubt = 0.0, magnitude = 0.0;
    for (uint k = 0; k < count_a; ++k) {
        const double3 edge_a = a[k + 1 == count_a ? 0 : k + 1] - a[k];
        const double length_a = sqrt(hr_dot_d(edge_a, edge_a));
        if (length_a == 0.0)
            continue;
        const double3 u = edge_a / length_a;
        for (uint l = 0; l < count_b; ++l) {
            const double3 edge_b = b[l + 1 == count_b ? 0 : l + 1] - b[l];
            const double length_b = sqrt(hr_dot_d(edge_b, edge_b));
            if (length_b == 0.0)
                continue;
            const double3 v = edge_b / length_b;
            const double cosine = hr_dot_d(u, v);
            if (hr_magnitude_d(cosine) < HR_EPSILON_D)
                continue;
            double pair_error;
            sum += cosine * hr_edge_pair(a[k], u, length_a, b[l], v, length_b, rules, &pair_error, &magnitude);
            doubt += hr_magnitude_d(cosine) * pair_error;
        }
    }
    *error = (doubt + 4.0 * HR_EPSILON_D * magnitude) / (2.0 * HR_PI_D);
    return sum / (2.0 * HR_PI_D);
}

#endif
