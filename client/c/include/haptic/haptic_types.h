#ifndef HAPTIC_HAPTIC_TYPES_H
#define HAPTIC_HAPTIC_TYPES_H
/* The structs and constants of haptic.h; those of contacts, of a state, and of the server and its
 * devices are in the headers that this one includes.
 *
 * Every struct that is passed by pointer begins with `size`. Set it to sizeof of the struct, and
 * the rest to 0; in C: `haptic_state state = {.size = sizeof state};`. A later release adds fields
 * at the end only. The library reads and writes no more than `size` bytes, so a program and a
 * library of different releases understand each other: the program's unknown fields must be 0, and
 * what the library does not know it sets to 0. Structs without `size` never change.
 *
 * Lists are arrays of a fixed, largest length: no list of a device is longer than HAPTIC_MAX_DOFS
 * or HAPTIC_MAX_COORDINATES. So a struct is copied as it is, nothing is allocated, and no pointer
 * has an owner. Text is UTF-8, ends with 0, and is cut at a whole character if it is too long.
 * Units are SI.
 */
#include <haptic/haptic_contact.h>
#include <haptic/haptic_facts.h>
#include <haptic/haptic_state.h>

/* Results of every function. */
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

typedef struct haptic_connect_options {
  size_t size;
  const char* address; /* "host:port" or "unix:/path" */
  int32_t tls;         /* 1: use TLS. The files below are PEM; each name may be NULL */
  const char* ca_file; /* NULL: the authorities that the system trusts */
  const char* certificate_file;
  const char* key_file;
  const char* server_name; /* NULL: the host in the address */
} haptic_connect_options;

enum { HAPTIC_STREAM_ONLY = 1, HAPTIC_UDP_ONLY = 2 }; /* options.carriers */
enum { HAPTIC_PRIORITY_TEST = 1, HAPTIC_PRIORITY_PRIMARY = 2, HAPTIC_PRIORITY_OPERATOR = 3 };

/* In options 0 and NULL select the default, which is said. */
typedef struct haptic_session_options {
  size_t size;
  const char* device;      /* NULL: the only device of the server */
  const char* client_name; /* "haptic client"; 1 to 64 bytes */
  int32_t observer;        /* 1: receives states, publishes nothing */
  int32_t tracker;         /* 1: publishes poses of the palm instead of proxies */
  int32_t
      priority; /* default HAPTIC_PRIORITY_PRIMARY; a higher one takes the device from a lower */
  int32_t carriers;       /* default: UDP while the server offers it and it works, or the stream */
  double nominal_rate_hz; /* how often you will publish, 1 to 2000; default 60 */
  double state_rate_hz;   /* states per second; default: one per tick */
  int32_t reconnect;      /* 1: a lost stream is opened again, and the session resumed */
  int32_t re_engage;      /* 1: force is asked for again after it was lost, never after a fault */
  int32_t derive_planes;  /* 1: a held proxy is sent as contacts, one per block */
  uint32_t timeout_ms;    /* of each call that waits for an answer; default 5000 */
  const haptic_block* blocks; /* for derive_planes; NULL: all coordinates are one */
  size_t block_count;
  /* Ages of a sample at which it stops being fresh, its force begins to fade, and is zero; each can
   * shorten the scene's limit, not lengthen it. Default: the scene's. */
  uint64_t fresh_end_ns, hold_end_ns, fade_end_ns;
} haptic_session_options;

/* Where the body that carries a device, for example the palm, is in the world. */
typedef struct haptic_pose {
  size_t size;
  double position[3];    /* m */
  double orientation[4]; /* unit quaternion x, y, z, w */
  uint32_t valid_for_us; /* it may count as fresh for so long; 0: as the scene says */
} haptic_pose;

/* One value per actuated DoF. In a wish a count of 0 leaves a list unchanged. */
typedef struct haptic_settings {
  size_t size;
  haptic_dofs stiffness, damping, force_limit, slew_limit;
  int32_t renderer;        /* a Renderer of session.proto; 0: unchanged */
  int32_t direction_guard; /* 1: acts, 2: does not; 0: unchanged */
  uint32_t clamped;        /* in an answer: values that were held at a limit of the scene */
  char why_clamped[512];   /* in an answer: each of them, with the limit; a line each */
} haptic_settings;

/* Something that happened once: `kind` is HAPTIC_EVENT_STATE, ... of haptic_state.h, or this. */
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
  int32_t udp_in_use; /* samples go by the UDP path */
  int64_t udp_round_trip_ns;
  uint64_t udp_received, udp_lost; /* datagrams of the server */
} haptic_statistics;

#endif
