/* Relaxation of x = d + S rho x one row after the other: Gauss-Seidel sweeps, and Southwell's shots.

   Rows follow each other, so that only columns are parallel; numbers are float, or double with HR_DOUBLE. */
#include "include/hr_types.h"

#if HR_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define HR_NUMBER double
#define HR_PACK double4
#define HR_LANES 4
#else
#define HR_NUMBER float
#define HR_PACK float8
#define HR_LANES 8
#endif

typedef __global const HR_PACK *hr_packs_in;
typedef __global HR_PACK *hr_packs;

HR_FORCE_INLINE HR_NUMBER hr_pack_sum(const HR_PACK p)
{
#if HR_DOUBLE
    return (p.s0 + p.s1) + (p.s2 + p.s3);
#else
    return ((p.s0 + p.s1) + (p.s2 + p.s3)) + ((p.s4 + p.s5) + (p.s6 + p.s7));
#endif
}

HR_FORCE_INLINE HR_NUMBER hr_absolute(const HR_NUMBER x)
{
    return x < 0 ? -x : x;
}

HR_FORCE_INLINE HR_PACK hr_size(const HR_PACK p)
{
    return p < (HR_PACK)(0) ? -p : p;
}

/* One sweep in the order of the rows: x_i = (d_i + sum over j != i of S_ij rho_j x_j) / (1 - S_ii rho_i), with the
   newest x_j. A work-group a pack of columns, whose first work-item does it. */
__kernel void gauss_seidel(__global const uint *link_start,       /* (n_rows + 1,)               */
                           __global const uint *link_source,      /* (n_links,)                  */
                           __global const HR_NUMBER *link_value,  /* (n_links,)                  */
                           __global const HR_NUMBER *reflectance, /* (n_rows, n_packs * HR_LANES) */
                           __global const HR_NUMBER *direct,      /* the same                    */
                           __global HR_NUMBER *light,             /* the same: x                 */
                           __global HR_NUMBER *reflected,         /* the same: rho x             */
                           const uint n_rows, const uint n_packs, const uint n_items)
{
    const uint pack = get_group_id(0);
    if (get_local_id(0) != 0 || pack >= n_packs || get_global_id(0) >= n_items)
        return;
    for (uint row = 0; row < n_rows; ++row) {
        const size_t own = (size_t)row * n_packs + pack;
        HR_PACK sum = ((hr_packs_in)direct)[own];
        HR_NUMBER self = 0;
        const uint end = link_start[row + 1];
        for (uint l = link_start[row]; l < end; ++l) {
            const uint source = link_source[l];
            if (source == row)
                self = link_value[l];
            else
                sum += link_value[l] * ((hr_packs_in)reflected)[(size_t)source * n_packs + pack];
        }
        const HR_PACK rho = ((hr_packs_in)reflectance)[own];
        sum /= (HR_NUMBER)1 - self * rho;
        ((hr_packs)light)[own] = sum;
        ((hr_packs)reflected)[own] = rho * sum;
    }
}

/* Shots, one after the other, of the row with the largest weighted power, all columns at once. What is unshot may be
   negative, after a start from a guess; the sizes of all columns count then. With HR_OVERSHOOT a row
   sends, in advance, what it will reflect of the ambient light: the power that is still unshot everywhere, after all
   its reflections, spread evenly (Feda & Purgathofer 1992); its unshot power is then negative until it received
   that. One work-item does it. */
__kernel void shoot_largest(__global const uint *link_start,       /* (n_rows + 1,)                               */
                            __global const uint *link_source,      /* (n_links,)                                  */
                            __global const HR_NUMBER *link_value,  /* (n_links,)                                  */
                            __global const HR_NUMBER *reflectance, /* (n_rows, n_packs * HR_LANES)                */
                            __global const HR_NUMBER *root_area,   /* (n_rows,) [m]                               */
                            __global const HR_NUMBER *weight,      /* (n_packs * HR_LANES,) of a column's power   */
                            __global const HR_NUMBER *gain,        /* the same: ambient light by unshot power     */
                            __global const HR_NUMBER *mean_gain,   /* (n_rows,) for the choice of the next row    */
                            __global HR_NUMBER *light,             /* (n_rows, n_packs * HR_LANES) x = d + S shot */
                            __global HR_NUMBER *shot,              /* the same                                    */
                            __global HR_NUMBER *unshot,            /* the same: rho x - shot                      */
                            __global HR_NUMBER *power,             /* (n_rows,) weighted unshot power, see above  */
                            __global HR_NUMBER *total,             /* (n_packs * HR_LANES,) unshot power of all   */
                            const uint n_rows, const uint n_packs, const uint n_shots, const uint n_items)
{
    if (get_global_id(0) >= n_items || get_global_id(0) != 0)
        return;
    for (uint k = 0; k < n_shots; ++k) {
        HR_NUMBER everywhere = 0;
#if HR_OVERSHOOT
        for (uint g = 0; g < n_packs; ++g)
            everywhere += hr_pack_sum(((hr_packs_in)weight)[g] * ((hr_packs_in)gain)[g] * ((hr_packs_in)total)[g]);
#endif
        uint row = 0;
        HR_NUMBER largest = 0;
        for (uint i = 0; i < n_rows; ++i) {
            const HR_NUMBER size = hr_absolute(power[i] + mean_gain[i] * everywhere);
            row = size > largest ? i : row;
            largest = size > largest ? size : largest;
        }
        if (!(largest > 0))
            return;
        const uint end = link_start[row + 1];
        power[row] = -mean_gain[row] * everywhere;
        for (uint g = 0; g < n_packs; ++g) {
            const size_t own = (size_t)row * n_packs + g;
            const HR_PACK w = ((hr_packs_in)weight)[g];
            const HR_NUMBER root = root_area[row];
            HR_PACK sum = ((hr_packs_in)total)[g];
            HR_PACK ahead = (HR_PACK)(0);
#if HR_OVERSHOOT
            ahead = root * ((hr_packs_in)reflectance)[own] * ((hr_packs_in)gain)[g] * sum;
#endif
            const HR_PACK sent = ((hr_packs_in)unshot)[own] + ahead;
            ((hr_packs)shot)[own] += sent;
            ((hr_packs)unshot)[own] = -ahead;
            sum -= root * sent;
            for (uint l = link_start[row]; l < end; ++l) {
                const uint at = link_source[l];
                const size_t there = (size_t)at * n_packs + g;
                const HR_PACK arriving = link_value[l] * sent;
                const HR_PACK reflected = ((hr_packs_in)reflectance)[there] * arriving;
                ((hr_packs)light)[there] += arriving;
                const HR_PACK before = ((hr_packs_in)unshot)[there];
                const HR_PACK after = before + reflected;
                ((hr_packs)unshot)[there] = after;
#if HR_OVERSHOOT
                power[at] += root_area[at] * hr_pack_sum(w * reflected);
#else
                power[at] += root_area[at] * hr_pack_sum(w * (hr_size(after) - hr_size(before)));
#endif
                sum += root_area[at] * reflected;
            }
            ((hr_packs)total)[g] = sum;
        }
    }
}
