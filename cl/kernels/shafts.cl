/* Proofs of sight between receivers and emitters, one pair a work-item. */
#include "include/hr_shaft.h"

__kernel void prove_sight(HR_BVH_PARAMS,
                          __global const float *receiver_corner, /* (n_receivers, 4, 3) [m], local            */
                          __global const float *receiver_normal, /* (n_receivers, 3) unit, of the lit side    */
                          __global const uint *receiver_patch,   /* (n_receivers,) or HR_NONE                 */
                          __global const float *emitter_corner,  /* (n_emitters, 4, 3) [m], local             */
                          __global const float *emitter_normal,  /* (n_emitters, 3) unit; 0: a point source   */
                          __global const uint *emitter_patch,    /* (n_emitters,) or HR_NONE                  */
                          __global const uint *emitter_two_sided, /* (n_emitters,)                            */
                          __global const uint *pair_receiver,    /* (n_items,)                                */
                          __global const uint *pair_emitter,     /* (n_items,)                                */
                          __global uchar *sight,                 /* (n_items,) HR_SIGHT_…                     */
                          const float scale, const float reach, const uint most_visits, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    const uint r = pair_receiver[i];
    const uint e = pair_emitter[i];
    float3 receiver[4], emitter[4];
    for (uint k = 0; k < 4u; ++k) {
        receiver[k] = hr_load3(receiver_corner, 4u * r + k);
        emitter[k] = hr_load3(emitter_corner, 4u * e + k);
    }
    sight[i] = (uchar)hr_sight(HR_BVH, receiver, hr_load3(receiver_normal, r), receiver_patch[r], emitter,
                               hr_load3(emitter_normal, e), emitter_patch[e], emitter_two_sided[e], scale, reach,
                               most_visits);
}
