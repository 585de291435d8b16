/* Contour integral for polygons that lie nearly in one plane, where the plain sum loses all digits: A F falls with q, the
   square of the chord between the normals, and the sum's terms do not. The second polygon is turned into the plane of
   the first about the line where both planes meet. Flat polygons see nothing of each other, so that their sum is 0 and
   only the change counts: for points s and t from that line, r^2 = r0^2 - q s t, and for two edges
   u . v ln r - u0 . v0 ln r0 = q/2 (du dv) ln r0 + u . v ln(1 - q s t / r0^2) / 2, each term of which falls with q. */
#ifndef HR_FLAT_CONTOUR_H
#define HR_FLAT_CONTOUR_H

#include "include/hr_contour.h"

/* What rounding of heights, over the polygons' extent, may be. */
#define HR_HEIGHT_ROUNDING 8.0e-15

/* ln(r / r0) between a point and four others. Flat coordinates: x is s of the first polygon, and -t of the second. */
HR_FORCE_INLINE double4 hr_bend(const double3 p, const double4 x, const double4 y, const double q)
{
    const double4 across = p.x - x, along = p.y - y;
    const double4 r2 = across * across + along * along;
    const double4 share = r2 > 0.0 ? p.x * x / r2 : (double4)(0.0);
    return 0.5 * log1p(q * share);
}

/* Mean of it over a part of an edge, from q0 + low v to q0 + high v; places may be mirrored about the middle. */
HR_FORCE_INLINE double4 hr_bend_nodes(const double3 p, const double3 q0, const double3 v, const double low,
                                      const double high, const double x0, const double x1, const double q)
{
    const double near0 = (high - low) * x0, near1 = (high - low) * x1;
    const double4 t = (double4)(low + near0, high - near0, low + near1, high - near1);
    return hr_bend(p, q0.x + t * v.x, q0.y + t * v.y, q);
}

/* The integral over a whole edge q0 + t v, t < 1, by double-exponential points on both sides of the place nearest to p.
   *coarse: with half the nodes. */
inline double hr_bend_edge(const double3 p, const double3 q0, const double3 v, const double q, const hr_rules rules,
                           double *coarse)
{
    __global const double *node = rules.node + rules.n_near + rules.n_far;
    __global const double *weight = rules.weight + rules.n_near + rules.n_far;
    double foot = hr_dot_d(p - q0, v) / hr_dot_d(v, v);
    foot = foot < 1.0e-12 ? 0.0 : foot > 1.0 - 1.0e-12 ? 1.0 : foot;
    double fine = 0.0, rough = 0.0;
    for (uint side = 0; side < 2; ++side) {
        const double low = side ? foot : 0.0, high = side ? 1.0 : foot;
        if (!(high > low))
            continue;
        double even = 0.0, odd = 0.0;
        for (uint k = 0; k < rules.n_fine; k += 2) {
            const double4 value = hr_bend_nodes(p, q0, v, low, high, node[k], node[k + 1], q);
            even += weight[k] * (value.x + value.y);
            odd += weight[k + 1] * (value.z + value.w);
        }
        fine += (high - low) * (even + odd);
        rough += (high - low) * 2.0 * rules.coarser_weight * even;
    }
    *coarse = rough;
    return fine;
}

/* Both edges in Gauss points: for edges that are at least half of the longer one apart. */
inline double hr_bend_far(const double3 p0, const double3 u, const double3 q0, const double3 v, const double q,
                          const hr_rules rules)
{
    double sum = 0.0;
    for (uint k = 0; k < 2 * rules.n_near; ++k) {
        const double x = rules.node[k / 2];
        const double3 p = p0 + (k % 2 ? 1.0 - x : x) * u;
        double inner = 0.0;
        for (uint l = 0; l < rules.n_near; l += 2) {
            const double4 value = hr_bend_nodes(p, q0, v, 0.0, 1.0, rules.node[l], rules.node[l + 1], q);
            inner += rules.weight[l] * (value.x + value.y) + rules.weight[l + 1] * (value.z + value.w);
        }
        sum += rules.weight[k / 2] * inner;
    }
    return sum;
}

/* Part of the first edge, from p0 + low u to p0 + high u. *coarse: with half the nodes on both edges. */
inline double hr_bend_piece(const double3 p0, const double3 u, const double low, const double high, const double3 q0,
                            const double3 v, const double q, const hr_rules rules, double *coarse)
{
    __global const double *node = rules.node + rules.n_near + rules.n_far;
    __global const double *weight = rules.weight + rules.n_near + rules.n_far;
    double fine = 0.0, rough = 0.0;
    for (uint k = 0; k < 2 * rules.n_fine; ++k) {
        const double step = (high - low) * node[k / 2];
        const double3 p = p0 + (k % 2 ? high - step : low + step) * u;
        double inner_coarse;
        fine += weight[k / 2] * hr_bend_edge(p, q0, v, q, rules, &inner_coarse);
        if (k / 2 % 2 == 0)
            rough += 2.0 * rules.coarser_weight * weight[k / 2] * inner_coarse;
    }
    *coarse = rough * (high - low);
    return fine * (high - low);
}

/* Mean of ln(r / r0) over two edges p0 + s u and q0 + t v of flat polygons, s and t < 1. */
inline double hr_bend_pair(const double3 p0, const double3 u, const double3 q0, const double3 v, const double q,
                           const hr_rules rules, double *error)
{
    *error = 0.0;
    if ((p0.x == 0.0 && u.x == 0.0) || (q0.x == 0.0 && v.x == 0.0))
        return 0.0;
    const double length_u = sqrt(hr_dot_d(u, u)), length_v = sqrt(hr_dot_d(v, v));
    const double longer = hr_larger_d(length_u, length_v);
    double crossing;
    const double distance2 = hr_edge_distance2(p0, u / length_u, length_u, q0, v / length_v, length_v, &crossing);
    if (distance2 >= 0.25 * longer * longer) {
        *error = rules.near_error * q;
        return hr_bend_far(p0, u, q0, v, q, rules);
    }
    crossing /= length_u;
    const double begin = hr_dot_d(q0 - p0, u) / (length_u * length_u);
    const double end = begin + hr_dot_d(u, v) / (length_u * length_u);
    const double low = hr_smaller_d(begin, end), high = hr_larger_d(begin, end);
    const double cut[5] = {0.0, hr_smaller_d(low, crossing), hr_larger_d(low, hr_smaller_d(high, crossing)),
                           hr_larger_d(high, crossing), 1.0};
    double sum = 0.0, at = 0.0;
    for (uint k = 1; k < 5; ++k) {
        const double to = k == 4 || cut[k] > 1.0 - 1.0e-9 ? 1.0 : cut[k];
        if (to - at <= 1.0e-9)
            continue;
        double coarse;
        const double fine = hr_bend_piece(p0, u, at, to, q0, v, q, rules, &coarse);
        const double relative = hr_magnitude_d(fine - coarse) / (q * (to - at));
        /* As with logarithms, but kinks of the inner integral at its ends make half the nodes less telling. */
        *error += q * (to - at) * relative * hr_smaller_d(1.0, 32.0 * sqrt(relative));
        sum += fine;
        at = to;
    }
    return sum;
}

/* Corners (x, y, 0) in the plane of the first polygon of a polygon on one side of the line where the planes meet.
   height: unit normal of the other polygon's plane, from the point `other` on it. sign: 1 or -1, of x. */
inline void hr_flatten(double3 *corner, const uint count, const double3 other, const double3 height, const double sine,
                       const double3 along, const double sign)
{
    for (uint k = 0; k < count; ++k) {
        const double h = hr_dot_d(corner[k] - other, height);
        corner[k] = (double3)(sign * (h > 0.0 ? h / sine : 0.0), hr_dot_d(corner[k], along), 0.0);
    }
}

/* A F of two convex polygons that see all of each other, whose normals na and nb differ by less than a right angle;
   corners are changed. *error: of the quadrature; *rounding: of cancellation, and of where the planes meet. */
inline double hr_flat_contour_exchange(double3 *a, const uint count_a, const double3 na, double3 *b, const uint count_b,
                                       const double3 nb, const hr_rules rules, double *error, double *rounding)
{
    const double3 change = nb - na;
    const double q = hr_dot_d(change, change);
    const double sine = sqrt(q * (1.0 - 0.25 * q));
    *error = *rounding = 0.0;
    if (!(sine > 0.0))
        return 0.0;
    const double3 along = hr_cross_d(na, (change + 0.5 * q * na) / sine);
    const double3 on_a = a[0], on_b = b[0];
    hr_flatten(a, count_a, on_b, nb, sine, along, 1.0);
    hr_flatten(b, count_b, on_a, na, sine, along, -1.0);
    double sum = 0.0, doubt = 0.0, magnitude = 0.0;
    for (uint k = 0; k < count_a; ++k) {
        const double3 u = a[k + 1 == count_a ? 0 : k + 1] - a[k];
        const double length_u = sqrt(hr_dot_d(u, u));
        for (uint l = 0; l < count_b && length_u > 0.0; ++l) {
            const double3 v = b[l + 1 == count_b ? 0 : l + 1] - b[l];
            const double length_v = sqrt(hr_dot_d(v, v));
            if (length_v == 0.0)
                continue;
            /* x of the second polygon runs against its own t: the flat product has cosine 1, the bent one 1 - q/2. */
            const double turned = -0.5 * q * u.x * v.x;
            const double product = hr_dot_d(u, v) + turned;
            double pair_error, size = 0.0;
            if (turned != 0.0) {
                const double inverse = 1.0 / (length_u * length_v);
                const double log_mean = inverse * hr_edge_pair(a[k], u / length_u, length_u, b[l], v / length_v,
                                                               length_v, rules, &pair_error, &size);
                sum += turned * log_mean;
                doubt += hr_magnitude_d(turned) * inverse * pair_error;
                magnitude += hr_magnitude_d(turned) * inverse * size;
            }
            sum += product * hr_bend_pair(a[k], u, b[l], v, q, rules, &pair_error);
            doubt += hr_magnitude_d(product) * pair_error;
            magnitude += q * length_u * length_v;
        }
    }
    *error = doubt / (2.0 * HR_PI_D);
    sum /= 2.0 * HR_PI_D;
    *rounding = 4.0 * HR_EPSILON_D * magnitude / (2.0 * HR_PI_D) + HR_HEIGHT_ROUNDING / sine * hr_magnitude_d(sum);
    return sum;
}

#endif
