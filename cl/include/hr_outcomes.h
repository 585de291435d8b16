/* What became of a ray that did not end on a row element. Values as in hradiosity/space/hierarchy.py. */
#ifndef HR_OUTCOMES_H
#define HR_OUTCOMES_H

#define HR_MISS 0xFFFFFFFFu    /* left the scene below the horizon                        */
#define HR_SKY 0xFFFFFFFEu     /* left the scene above the horizon                        */
#define HR_COVERED 0xFFFFFFFDu /* started inside a solid: that point of the element is covered */
#define HR_UNLIT 0xFFFFFFFCu   /* ended on a side that no light was found to reach        */
#define HR_LONG 0xFFFFFFFBu    /* of a path: not ended where its places for lit hits did       */
#define HR_IS_ROW(outcome) ((outcome) < HR_LONG)

#endif
