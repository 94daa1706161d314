#ifndef HAPTIC_HAPTIC_CONTACT_H
#define HAPTIC_HAPTIC_CONTACT_H
/* A simulation's objects as it tells them: planes and contacts, and the geometry that makes them.
 * The rules of structs are in haptic_types.h. */
#include <haptic/haptic_plane.h>
#include <haptic/haptic_state.h>

/* Where the simulation's objects let the probe be. */
typedef struct haptic_proxy {
  size_t size;
  int32_t mode;             /* HAPTIC_HELD, HAPTIC_FREE or HAPTIC_PLANES */
  uint32_t valid_for_us;    /* it may count as fresh for so long; 0: as the scene says */
  uint64_t device_seq_used; /* the state that it was computed from; 0: the last one given */
  const double* x;          /* `count` values, one per coordinate; NULL if free */
  size_t count;
  const haptic_plane* planes; /* `plane_count` of them, each of the size planes[0].size */
  size_t plane_count;
} haptic_proxy;

/* Consecutive coordinates that are constrained together: a fingertip, a joint, a tool. */
typedef struct haptic_block {
  uint32_t first, count;
} haptic_block;

/* Your objects: writes up to `capacity` contacts of the tool at x, touched or near, and returns how
 * many there are; a negative number gives up. Each comes with both its sizes set, and the rest 0.
 */
typedef int64_t (*haptic_contacts_at)(const double* x, size_t count, haptic_contact* contacts,
                                      size_t capacity, void* user);

/* In options 0 and NULL select the default, which is said. */
typedef struct haptic_solve_options {
  size_t size;
  const double* start;   /* where to begin: the last proxy; default: the probe */
  const double* weights; /* of each coordinate's distance, > 0; default: 1 */
  int32_t iterations;    /* of Newton's method, at most; default 50 */
  double tolerance;      /* of each coordinate, in its unit; default 1e-10 */
} haptic_solve_options;

typedef struct haptic_solution {
  size_t size;
  int32_t converged; /* 0: x is the best that was found, and may be published */
  int32_t iterations;
  haptic_coordinates x; /* the proxy */
  size_t plane_count;   /* of all contacts at x */
} haptic_solution;

#endif
