/* What is sure about the sight between two places. Values as in hradiosity/space/shafts.py. */
#ifndef HR_SIGHT_H
#define HR_SIGHT_H

#define HR_SIGHT_UNKNOWN 0u
#define HR_SIGHT_FREE 1u   /* nothing stands between any two points of both                      */
#define HR_SIGHT_HIDDEN 2u /* the one lies behind the other: no light goes between them */

#endif
