/* What a point receives from a convex polygon, in double precision: Lambert's formula, which is the area of the
   polygon's projection on the hemisphere and from there on the base (Nusselt 1928), and the same with the arcs of the
   projection replaced by chords. */
#ifndef HR_LAMBERT_H
#define HR_LAMBERT_H

#include "include/hr_double.h"

/* Halvings that stand for the exact arc. */
#define HR_EXACT_ARC 255u

/* Angle over sine of an arc whose sine is y >= 0 and cosine x, both times one length; or, when its 2^halvings equal
   chords stand for it, their sines' sum over the sine. No arc function is needed for chords: the cosine is halved. */
HR_FORCE_INLINE double hr_arc_over_sine(const double y, const double x, const uint halvings)
{
    if (halvings == HR_EXACT_ARC)
        return atan2(y, x) / y;
    const double length = sqrt(x * x + y * y);
    double cosine = x / length;
    double ratio = 1.0;
    for (uint k = 0; k < halvings; ++k) {
        cosine = sqrt(0.5 * hr_larger_d(1.0 + cosine, HR_EPSILON_D));
        /* 2 sin(t / 2) = sin t / cos(t / 2) */
        ratio /= cosine;
    }
    return ratio / length;
}

/* One edge: r from the point to its start, e the edge itself (see hr_edge_term). */
HR_FORCE_INLINE double hr_lambert_edge(const double3 n, const double3 r, const double3 e, const uint halvings)
{
    const double3 c = hr_cross_d(r, e);
    const double sine = sqrt(hr_dot_d(c, c));
    return sine > 0.0 ? hr_dot_d(n, c) * hr_arc_over_sine(sine, hr_dot_d(r, r + e), halvings) : 0.0;
}

/* Form factor of a point with unit normal n to the part above its horizon of a polygon with corners r[k], seen from
   the point. Positive whatever the winding. [1] */
inline double hr_lambert(const double3 n, const double3 *r, const uint count, const uint halvings)
{
    double sum = 0.0;
    double3 leave = (double3)(0.0), enter = (double3)(0.0);
    int cut = 0;
    for (uint k = 0; k < count; ++k) {
        const double3 a = r[k];
        const double3 b = r[k + 1 == count ? 0 : k + 1];
        const double ha = hr_dot_d(n, a), hb = hr_dot_d(n, b);
        if (ha <= 0.0 && hb <= 0.0)
            continue;
        const double3 e = b - a;
        const double crossing = ha / (ha - hb);
        double3 start = a, along = e;
        if (ha <= 0.0) {
            start = a + crossing * e;
            along = (1.0 - crossing) * e;
            enter = start;
            cut = 1;
        }
        if (hb <= 0.0) {
            along = crossing * e;
            leave = a + along;
            cut = 1;
        }
        sum += hr_lambert_edge(n, start, along, halvings);
    }
    if (cut)
        sum += hr_lambert_edge(n, leave, enter - leave, halvings);
    return hr_magnitude_d(sum) / (2.0 * HR_PI_D);
}

#endif
