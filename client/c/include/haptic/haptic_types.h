#ifndef HAPTIC_HAPTIC_TYPES_H
#define HAPTIC_HAPTIC_TYPES_H
/* The structs and constants of haptic.h.
 *
 * Every struct that is passed by pointer begins with `size`. Set it to sizeof of the struct, and
 * the rest to 0; in C: `haptic_state state = {.size = sizeof state};`. A later release adds fields
 * at the end only. The library reads and writes no more than `size` bytes, so a program and a
 * library of different releases understand each other: the program's unknown fields must be 0, and
 * what the library does not know it sets to 0. Structs without `size` never change.
 *
 * Lists are arrays of a fixed, largest length: no list of a device is longer than these two. So a
 * struct is copied as it is, nothing is allocated, and no pointer has an owner. Text is UTF-8, ends
 * with 0, and is cut at a whole character if it is too long. Units are SI.
 */
#include <stddef.h>
#include <stdint.h>

#define HAPTIC_MAX_DOFS 24
#define HAPTIC_MAX_COORDINATES 72
#define HAPTIC_MAX_NAME 64

/* What every function returns. */
enum {
  HAPTIC_OK = 0,
  HAPTIC_NOTHING = 1, /* nothing waits: no event, no refusal */
  HAPTIC_ERROR_UNREACHABLE = -1,
  HAPTIC_ERROR_TIMEOUT = -2,
  HAPTIC_ERROR_NO_SUCH_DEVICE = -3,
  HAPTIC_ERROR_LEASE_HELD = -4,        /* another controller has the device */
  HAPTIC_ERROR_INVALID_ARGUMENT = -5,  /* the message names it and what is allowed */
  HAPTIC_ERROR_NOT_READY = -6,         /* the message says what is missing yet */
  HAPTIC_ERROR_PERMISSION_DENIED = -7, /* not this session's to ask */
  HAPTIC_ERROR_CLOSED = -8,            /* the session ended, or the handle is NULL or closed */
  HAPTIC_ERROR_PROTOCOL = -9,          /* an answer that this library does not understand */
  HAPTIC_ERROR_NO_MEMORY = -10,
  HAPTIC_ERROR_INTERNAL = -11
};

/* Why a call failed; the last argument of every call that can, or NULL. */
typedef struct haptic_error {
  size_t size;
  int32_t code;
  char server_reason[HAPTIC_MAX_NAME]; /* stable, "STREAM_TOO_YOUNG"; empty: the server gave none */
  char message[512];                   /* for people */
} haptic_error;

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

typedef struct haptic_connect_options {
  size_t size;
  const char* address; /* "host:port" or "unix:/path" */
  int32_t tls;         /* 1: use TLS. The files below are PEM; each name may be NULL */
  const char* ca_file; /* NULL: the authorities that the system trusts */
  const char* certificate_file;
  const char* key_file;
  const char* server_name; /* NULL: the host in the address */
} haptic_connect_options;

typedef struct haptic_dof {
  char name[HAPTIC_MAX_NAME];
  char unit[8]; /* "m" or "rad" */
  int32_t actuated;
  double lower, upper; /* its range */
  double max_effort;   /* N or N m */
} haptic_dof;

typedef struct haptic_coordinate {
  char name[HAPTIC_MAX_NAME];
  char unit[8];
  char kind[16]; /* "linear", "angle" (wraps) or "quaternion" (four in a row) */
} haptic_coordinate;

typedef struct haptic_device {
  size_t size;
  char name[HAPTIC_MAX_NAME], kind[HAPTIC_MAX_NAME], model[HAPTIC_MAX_NAME];
  char controller[HAPTIC_MAX_NAME + 1]; /* client_name of who has the lease; empty: none */
  int32_t moves;                        /* 0: a recording, which no force moves */
  int32_t wants_tracker;
  int32_t state;
  uint32_t faults;
  double loop_rate_hz;
  uint32_t dof_count, actuated_count, coordinate_count;
  haptic_dof dofs[HAPTIC_MAX_DOFS];
  haptic_coordinate coordinates[HAPTIC_MAX_COORDINATES];
} haptic_device;

/* In options 0 and NULL select the default, which is said. */
typedef struct haptic_session_options {
  size_t size;
  const char* device;      /* NULL: the only device of the server */
  const char* client_name; /* "haptic client"; 1 to 64 bytes */
  int32_t observer;        /* 1: receives states, publishes nothing */
  int32_t priority;        /* 1 test, 2 primary (default), 3 operator */
  double nominal_rate_hz;  /* how often you will publish, 1 to 2000; default 60 */
  double state_rate_hz;    /* states per second; default: one per tick */
  int32_t stream_only;     /* 1: no UDP */
  int32_t reconnect;       /* 1: a lost stream is opened again */
  int32_t re_engage;       /* 1: force is asked for again after it was lost, never after a fault */
  int32_t derive_planes;   /* 1: a held proxy is sent as contacts */
  uint32_t timeout_ms;     /* of each call that waits for an answer; default 5000 */
} haptic_session_options;

/* One value per DoF or per actuated DoF, and one per coordinate. count 0: the list is absent. */
typedef struct haptic_dofs {
  uint32_t count;
  double value[HAPTIC_MAX_DOFS];
} haptic_dofs;
typedef struct haptic_coordinates {
  uint32_t count;
  double value[HAPTIC_MAX_COORDINATES];
} haptic_coordinates;

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
  haptic_dofs temperature_c;
  int32_t projection; /* a ProjectionStatus of session.proto */
  int32_t derating;   /* a Derating of session.proto */
  uint64_t derating_delay_us;
  double condition, unexplained;
} haptic_state;

/* A half space that the proxy must stay in, normal . x <= offset; or a contact. Of a contact with
 * this gap (> 0: not touched) and gradient of the gap at x: normal = -gradient, offset = gap +
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

/* One value per actuated DoF. As a wish, a count of 0 leaves a list unchanged. */
typedef struct haptic_settings {
  size_t size;
  haptic_dofs stiffness, damping, force_limit, slew_limit;
  int32_t renderer;        /* a Renderer of session.proto; 0: unchanged */
  int32_t direction_guard; /* 1: acts, 2: does not; 0: unchanged */
  uint32_t clamped;        /* in an answer: values that were held at a limit of the scene */
} haptic_settings;

/* Something that happened once: `kind` is an Event.Kind of session.proto, or this. */
enum { HAPTIC_EVENT_DISCONNECTED = 1000 }; /* state 1: the session reconnects; 0: it ended */
typedef struct haptic_event {
  size_t size;
  int32_t kind;
  int32_t state; /* lifecycle */
  int64_t server_time_ns;
  uint64_t lost; /* events before this one that were dropped because 256 waited */
  char reason[HAPTIC_MAX_NAME];
  char message[256];
} haptic_event;

typedef struct haptic_statistics {
  size_t size;
  uint64_t published, sent, conflated, planes_left_out;
  uint64_t accepted, rejected_old, rejected_invalid, backlog; /* as the server counts */
  int64_t round_trip_ns; /* from a sample to the first state that used it; 0: not known yet */
  uint32_t lease_epoch;
  int32_t connected;
  char last_rejection[256];
} haptic_statistics;

#endif
