/* Exchange of two polygons as a double integral over their contours (Stokes):
   A F = 1/(2 pi) | sum over edges a, b of (u_a . u_b) * integral integral ln|p - q| dp dq |.
   One integral is closed (Mitalas & Stephenson 1966); the other one is closed for parallel edges, else by quadrature
   that crowds points where the edges come near each other. */
#ifndef HR_CONTOUR_H
#define HR_CONTOUR_H

#include "include/hr_double.h"

/* Sine of the angle below which edges count as parallel. */
#define HR_PARALLEL 1.0e-12

/* Nodes in [0, 1/2] of rules on [0, 1] that are symmetric about the middle, with weights; of each rule an even number,
   filled up with weight 0. */
typedef struct {
    __global const double *node;
    __global const double *weight;
    uint n_near; /* nodes of the rule for edges at least half a length apart, first in the arrays */
    uint n_far;  /* nodes of the rule for edges further apart than 1.5 lengths, next */
    uint n_fine; /* nodes of the double-exponential rule, next; every second one belongs to the coarser one */
    double near_error;     /* error of the first two rules, over the product of the edges' lengths */
    double coarser_weight; /* what twice the weights of the coarser one is to be multiplied by, so that they add up to 1 */
    double crowded_error;  /* error of the double-exponential rule over the root of its difference from the coarser one,
                              both over the product of the lengths */
} hr_rules;

/* integral of ln|p - q| dq over the edge from q0 along the unit vector v, for four points p at a time. Written about the
   farther end, at distance r: L ln r + c ln(r'/r) - L + h atan2(L h, h^2 + t t'), where the nearer end lies at distance
   r' and its foot c beyond it. No term is larger than L, so that far edges keep their digits. */
HR_FORCE_INLINE double4 hr_log_integral(const double4 px, const double4 py, const double4 pz, const double3 q0,
                                        const double3 v, const double length)
{
    const double4 x = q0.x - px, y = q0.y - py, z = q0.z - pz;
    const double4 start = v.x * x + v.y * y + v.z * z;
    const double4 off_x = y * v.z - z * v.y, off_y = z * v.x - x * v.z, off_z = x * v.y - y * v.x;
    const double4 h2 = off_x * off_x + off_y * off_y + off_z * off_z;
    const double4 h = sqrt(h2);
    const double4 end = start + length;
    const double4 start2 = h2 + start * start, end2 = h2 + end * end;
    const long4 end_is_far = start + end >= 0.0;
    const double4 far2 = end_is_far ? end2 : start2;
    const double4 near2 = end_is_far ? start2 : end2;
    const double4 beyond = end_is_far ? -start : end;
    const double4 drop = -length * (end_is_far ? start + end : -start - end) / far2;
    const double4 ratio = near2 > 0.0 ? near2 / far2 : (double4)(1.0);
    const double4 log_ratio = drop > -0.5 ? log1p(drop) : log(ratio);
    const double4 angle = atan2(length * h, h2 + start * end);
    return 0.5 * (length * log(far2) + beyond * log_ratio) - length + h * angle;
}

/* The same from points p0 + s u at two places and their mirror images: s = low + length x and high - length x. */
HR_FORCE_INLINE double4 hr_mirrored_integrals(const double3 p0, const double3 u, const double low, const double high,
                                              const double x0, const double x1, const double3 q0, const double3 v,
                                              const double length)
{
    const double near0 = (high - low) * x0, near1 = (high - low) * x1;
    const double4 s = (double4)(low + near0, high - near0, low + near1, high - near1);
    return hr_log_integral(p0.x + s * u.x, p0.y + s * u.y, p0.z + s * u.z, q0, v, length);
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
    for (uint k = 0; k < n; k += 2) {
        const double4 value = hr_mirrored_integrals(p0, u, 0.0, length_a, node[k], node[k + 1], q0, v, length_b);
        sum += weight[k] * (value.x + value.y) + weight[k + 1] * (value.z + value.w);
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
    for (uint k = 0; k < rules.n_fine; k += 2) {
        const double4 value = hr_mirrored_integrals(p0, u, low, high, node[k], node[k + 1], q0, v, length_b);
        even += weight[k] * (value.x + value.y);
        odd += weight[k + 1] * (value.z + value.w);
    }
    *coarse = 2.0 * even * rules.coarser_weight * length;
    return (even + odd) * length;
}

/* Error of the rule from what half the nodes change, both over the size of the integral. Places near an end from which
   on the integrand is no longer analytic, a common corner of edges at a small angle above all, leave few digits to either
   rule and many to none: the digits don't simply double. */
HR_FORCE_INLINE double hr_crowded_error(const double change, const hr_rules rules)
{
    return hr_smaller_d(change, rules.crowded_error * sqrt(change));
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
        const double size = (to - at) * length_b;
        *error += size * hr_crowded_error(hr_magnitude_d(fine - coarse) / size, rules);
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
        *error = rules.near_error * short_length * long_length;
    } else if (hr_dot_d(normal, normal) < HR_PARALLEL * HR_PARALLEL) {
        const double3 r = q0 - p0;
        const double3 off = hr_cross_d(r, along);
        const double x = hr_dot_d(r, along) - (cosine < 0.0 ? long_length : 0.0);
        value = hr_parallel_edges(x, sqrt(hr_dot_d(off, off)), short_length, long_length);
        *magnitude += long_length * long_length;
    } else if (distance2 >= 0.25 * short2) {
        value = hr_smooth_piece(p0, along, short_length, q0, other, long_length, rules.node, rules.weight,
                                rules.n_near);
        *error = rules.near_error * short_length * long_length;
    } else {
        value = hr_crowded_edges(p0, along, short_length, q0, other, long_length, crossing, rules, error);
    }
    *magnitude += short_length * long_length;
    return value;
}

/* A F of two convex polygons that see all of each other, from corners in units of about their extent. *error: of the
   quadrature; *rounding: what cancellation leaves, whatever the quadrature. */
inline double hr_contour_exchange(const double3 *a, const uint count_a, const double3 *b, const uint count_b,
                                  const hr_rules rules, double *error, double *rounding)
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
    *error = doubt / (2.0 * HR_PI_D);
    *rounding = 4.0 * HR_EPSILON_D * magnitude / (2.0 * HR_PI_D);
    return sum / (2.0 * HR_PI_D);
}

#endif
