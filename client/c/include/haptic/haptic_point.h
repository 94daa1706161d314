#ifndef HAPTIC_HAPTIC_POINT_H
#define HAPTIC_HAPTIC_POINT_H
/* A point of the tool. The rules of structs are in haptic_types.h. */
#include <haptic/haptic_lists.h>

#define HAPTIC_MAX_POINT_COORDINATES 8 /* that one point depends on */

/* A joint as it stands now. */
typedef struct haptic_joint {
  double origin[3]; /* a point of the axis, m; without a meaning if prismatic */
  double axis[3];   /* of length 1; right-handed */
  int32_t prismatic;
} haptic_joint;

/* A point of the tool, and how it moves with `count` consecutive coordinates. */
typedef struct haptic_point {
  size_t size;
  uint32_t first_coordinate, count;
  int32_t has_second;                               /* 0: `second` is 0 */
  double position[3];                               /* p, m */
  double jacobian[HAPTIC_MAX_POINT_COORDINATES][3]; /* dp/dx_j, m per unit of x_j */
  double second[36][3];                             /* d2p/dx_j dx_k: lower triangle, row by row */
} haptic_point;

#endif
