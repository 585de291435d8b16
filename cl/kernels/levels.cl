/* Values of row elements summed up the trees of nodes, and values of nodes handed down; eight columns at a time. */
#include "include/hr_columns.h"
#include "include/hr_types.h"

/* The leaves: weight times value; one work-item a row and group of columns. */
__kernel void pull_rows(__global const float *weight,  /* (n_rows,)            */
                        __global const float *columns, /* (n_rows, 8 n_groups) */
                        __global float *pulled,        /* (n_nodes, 8 n_groups) */
                        const uint n_items)
{
    const uint i = get_global_id(0);
    if (i < n_items)
        ((hr_groups_out)pulled)[i] = weight[i / HR_GROUPS] * ((hr_groups_in)columns)[i];
}

/* Nodes of one level: the sum of their children. */
__kernel void pull_nodes(__global const uint *child_start, /* (n_nodes + 1,)        */
                         __global const uint *child,       /* (n_nodes - n_roots,)  */
                         __global float *pulled,           /* (n_nodes, 8 n_groups) */
                         const uint first_node, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint node = first_node + i / HR_GROUPS, group = i % HR_GROUPS;
    float8 sum = (float8)(0.0f);
    for (uint k = child_start[node]; k < child_start[node + 1]; ++k)
        sum += ((hr_groups_in)pulled)[(size_t)child[k] * HR_GROUPS + group];
    ((hr_groups_out)pulled)[(size_t)node * HR_GROUPS + group] = sum;
}

/* What each row element receives: all that it and the nodes above it gathered, times its weight, and its own light. */
__kernel void push_rows(__global const uint *parent,    /* (n_nodes,) or HR_NONE */
                        __global const float *weight,   /* (n_rows,)             */
                        __global const float *own,      /* (n_rows,)             */
                        __global const float *columns,  /* (n_rows, 8 n_groups)  */
                        __global const float *gathered, /* (n_nodes, 8 n_groups) */
                        __global float *product,        /* (n_rows, 8 n_groups)  */
                        const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint row = i / HR_GROUPS, group = i % HR_GROUPS;
    float8 sum = (float8)(0.0f);
    for (uint node = row; node != HR_NONE; node = parent[node])
        sum += ((hr_groups_in)gathered)[(size_t)node * HR_GROUPS + group];
    ((hr_groups_out)product)[i] = weight[row] * sum + own[row] * ((hr_groups_in)columns)[i];
}
