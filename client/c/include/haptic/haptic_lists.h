#ifndef HAPTIC_HAPTIC_LISTS_H
#define HAPTIC_HAPTIC_LISTS_H
/* Lists and constants of haptic_state.h. The rules of structs are in haptic_types.h. */
#include <stddef.h>
#include <stdint.h>

#define HAPTIC_MAX_DOFS 24
#define HAPTIC_MAX_COORDINATES 72

/* Lifecycle of a device: haptic_state.state. Force is rendered from ENGAGING to RELEASING only. */
enum {
  HAPTIC_INIT = 1,
  HAPTIC_IDLE = 2,
  HAPTIC_ARMED = 3,
  HAPTIC_ENGAGING = 4,
  HAPTIC_ENGAGED = 5,
  HAPTIC_RELEASING = 6,
  HAPTIC_FAULT = 7,
  HAPTIC_CLOSING = 8
};
enum { HAPTIC_HELD = 1, HAPTIC_FREE = 2, HAPTIC_PLANES = 3 };                 /* state.mode */
enum { HAPTIC_FRESH = 1, HAPTIC_HOLD = 2, HAPTIC_FADE = 3, HAPTIC_LOST = 4 }; /* .staleness */
enum { HAPTIC_BY_STREAM = 1, HAPTIC_BY_UDP = 2 };                             /* .carrier */

/* One value per DoF or per actuated DoF, and one per coordinate. count 0: the list is absent. */
typedef struct haptic_dofs {
  uint32_t count;
  double value[HAPTIC_MAX_DOFS];
} haptic_dofs;
typedef struct haptic_coordinates {
  uint32_t count;
  double value[HAPTIC_MAX_COORDINATES];
} haptic_coordinates;
typedef struct haptic_dof_bits {
  uint32_t count;
  uint32_t value[HAPTIC_MAX_DOFS];
} haptic_dof_bits;

#endif
