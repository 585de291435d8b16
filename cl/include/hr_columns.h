/* Rows of spectral columns, eight at a time. */
#ifndef HR_COLUMNS_H
#define HR_COLUMNS_H

/* Aligned pointers: PoCL calls vload8 and vstore8 as functions. */
typedef __global const float8 *hr_groups_in;
typedef __global float8 *hr_groups_out;

#endif
