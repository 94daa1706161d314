#ifndef HAPTIC_HAPTIC_STATE_H
#define HAPTIC_HAPTIC_STATE_H
/* The state of a device at one tick, as the server tells it. The rules of structs are in
 * haptic_types.h. */
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

/* The server's account of energy; core/METHOD.md, Energy tank. */
typedef struct haptic_passivity {
  int32_t present; /* 0: the scene has neither tank nor observer */
  double tank, storage;
  double scale; /* of the spring's deviation; below 1 the tank throttles it */
  double observed;
  double alpha; /* s; the passivity controller adds alpha times the stiffness as damping */
} haptic_passivity;

/* The tracker's pose in use. */
typedef struct haptic_tracker {
  int32_t present; /* 0: the scene has no tracker */
  int32_t staleness;
  uint64_t seq_used; /* 0: none came so far */
  uint64_t age_us;
} haptic_tracker;

/* The device at one tick; proto/haptic/v1/session.proto says more of each. */
typedef struct haptic_state {
  size_t size;
  uint64_t seq;            /* number of the tick; 0: no state came yet */
  int64_t server_time_ns;  /* the server's steady clock */
  uint64_t proxy_seq_used; /* number of the sample in use; 0: none */
  uint64_t proxy_age_us;
  int32_t state, mode, staleness, carrier;
  uint32_t lease_epoch;
  uint32_t faults, limiters; /* bits */
  uint32_t active_planes;    /* bit n: plane n of the newest sample holds x */
  double gain;               /* on the elastic force, 0 to 1 */
  haptic_dofs q;             /* where the device is, per DoF */
  haptic_dofs q_dot;         /* per actuated DoF */
  haptic_coordinates x_probe;
  haptic_coordinates x;    /* the proxy in use */
  haptic_dofs q_star;      /* the subspace proxy in use, per DoF */
  haptic_dofs tau_a;       /* the command, N or N m per actuated DoF */
  haptic_dofs tau_elastic; /* its elastic part */
  haptic_dofs error_bound; /* of tau_elastic */
  haptic_dofs stiffness_in_effect;
  haptic_dofs tau_measured;
  haptic_dofs drive; /* sent to the device instead of tau_a; absent: tau_a is */
  haptic_dofs temperature_c;
  haptic_dofs reading; /* what the sensors said, if that was refused; absent: it is q */
  haptic_dof_bits actuator_limiters;
  haptic_passivity passivity;
  haptic_tracker tracker;
  int32_t projection; /* a ProjectionStatus of session.proto */
  int32_t derating;   /* a Derating of session.proto */
  uint64_t derating_delay_us;
  double condition, unexplained;
} haptic_state;

#endif
