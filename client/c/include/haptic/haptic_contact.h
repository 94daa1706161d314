#ifndef HAPTIC_HAPTIC_CONTACT_H
#define HAPTIC_HAPTIC_CONTACT_H
/* A simulation's objects as it tells them: planes and contacts, and the geometry that makes them.
 * The rules of structs are in haptic_types.h. */
#include <haptic/haptic_state.h>

#define HAPTIC_MAX_POINT_COORDINATES 8 /* that one point depends on */

/* A half space that the proxy must stay in, normal . x <= offset; or a contact. A contact with
 * this gap (> 0: not touched) and gradient of the gap at x has normal = -gradient, offset = gap +
 * normal . x. The other fields say how the object gives way and moves (proto/README.md, Contacts);
 * 0 is a rigid plane at rest. */
typedef struct haptic_plane {
  size_t size;
  double normal[HAPTIC_MAX_COORDINATES]; /* one value per coordinate of the device, not all 0 */
  double offset;
  double compliance; /* coupling / stiffness of the contact */
  double velocity;   /* of the offset, per s; > 0: the object recedes */
  uint32_t id;       /* names the contact from sample to sample; 0: none */
  uint32_t first_coordinate, curvature_count;
  double curvature[36]; /* lower triangle, row by row, from first_coordinate on */
  double mass, damping, ground_stiffness, load;
  int32_t has_uncertainty;
  uint32_t object, object_direction_count;
  double uncertainty;
  double object_direction[6];
} haptic_plane;

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

/* A point of the tool against an object. */
typedef struct haptic_contact {
  size_t size;
  haptic_point point;  /* its size too must be set */
  double normal[3];    /* of the object at the nearest point, outwards, of length 1 */
  double gap;          /* from the object to the point along the normal, m; < 0: inside */
  double curvature[6]; /* of the object; haptic_sphere_curvature() */
  double stiffness;    /* of point and object in series, N/m; 0: rigid */
  double velocity;     /* of the object along -normal, m/s; > 0: it recedes */
  uint32_t id;         /* names the contact from sample to sample; 0: none */
  uint32_t object;     /* names the body that is pushed, if several contacts push it */
  /* The law of an object that is pushed: kg, N s/m, N/m, and N: the force on it without this
   * contact's and the damping's, > 0: away from the tool. A mass needs an id. */
  double mass, damping, ground_stiffness, load;
  int32_t has_uncertainty;
  uint32_t object_direction_count; /* 0: the normal */
  double uncertainty;              /* the stiffness lies within 1 -+ this times what is told */
  double object_direction[6];
} haptic_contact;

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
