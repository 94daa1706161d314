#ifndef HAPTIC_HAPTIC_LISTS_H
#define HAPTIC_HAPTIC_LISTS_H
/* Lists and constants of haptic_state.h and haptic_facts.h. The rules of structs are in
 * haptic_types.h. */
#include <stddef.h>
#include <stdint.h>

#define HAPTIC_MAX_DOFS 24
#define HAPTIC_MAX_COORDINATES 72
#define HAPTIC_MAX_NAME 64 /* bytes */

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
