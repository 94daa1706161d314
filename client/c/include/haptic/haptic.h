#ifndef HAPTIC_HAPTIC_H
#define HAPTIC_HAPTIC_H
/* The client of hapticd for C and for every language that calls C: libhaptic. C99 and C++.
 *
 *   haptic_connect_options server = {.size = sizeof server, .address = "127.0.0.1:29470"};
 *   haptic_connection* connection = NULL;
 *   haptic_error error = {.size = sizeof error};
 *   if (haptic_connect(&server, &connection, &error) != HAPTIC_OK) puts(error.message);
 *
 * Words: the haptic probe is where the device is in the virtual space, the proxy where the
 * simulation's objects let it be. The server renders a force that pulls the probe to the proxy.
 *
 * - Every function returns HAPTIC_OK or another value of the first enum of haptic_types.h, and says
 *   why in `error`, which may be NULL. There is no other place for errors, and no state that
 *   threads share.
 * - A handle is a number in the shape of a pointer: the library looks it up and never reads through
 *   it. NULL, and a handle that was closed, give HAPTIC_ERROR_CLOSED; a number is not used twice.
 * - Every function may be called from any thread, at the same time as others on the same handle.
 *   The library calls nothing of yours. After fork() only the parent may use its handles; the
 *   child may exit().
 * - Connections and sessions may be closed in any order; exit() without closing is allowed, unless
 *   another thread opens a session then, and the server lets the force fade out.
 * - libhaptic brings the protocol's messages, and the system's libprotobuf ends a program that has
 *   them twice. So link either haptic::c or the C++ library haptic::client, not both.
 */
#include <haptic/haptic_types.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTIC_API __attribute__((visibility("default")))

typedef struct haptic_connection haptic_connection;
typedef struct haptic_session haptic_session;

/* "0.1.0" */
HAPTIC_API const char* haptic_version(void);

/* Returns at once, whether or not a server runs there. */
HAPTIC_API int haptic_connect(const haptic_connect_options* options, haptic_connection** connection,
                              haptic_error* error);
HAPTIC_API int haptic_disconnect(haptic_connection* connection);

/* Fills up to `capacity` devices; devices[0].size must be set. *count: how many the server has. */
HAPTIC_API int haptic_devices(haptic_connection* connection, haptic_device* devices,
                              size_t capacity, size_t* count, haptic_error* error);
/* Zero force at once, and the fault EMERGENCY_STOP until haptic_clear_fault(). device NULL: all of
 * them. reason: for the log, or NULL. */
HAPTIC_API int haptic_emergency_stop(haptic_connection* connection, const char* device,
                                     const char* reason, haptic_error* error);
/* faults: bits of haptic_state.faults; 0: all that are active. *cleared (or NULL): those that
 * were. */
HAPTIC_API int haptic_clear_fault(haptic_connection* connection, const char* device,
                                  uint32_t faults, uint32_t* cleared, haptic_error* error);

/* Waits until the server agrees. */
HAPTIC_API int haptic_open(haptic_connection* connection, const haptic_session_options* options,
                           haptic_session** session, haptic_error* error);
/* Ends the session; calls that wait on other threads return HAPTIC_ERROR_CLOSED. */
HAPTIC_API int haptic_close(haptic_session* session);
/* The device as it was when the session opened. */
HAPTIC_API int haptic_device_of(haptic_session* session, haptic_device* device,
                                haptic_error* error);

/* Copies the newest state. Never waits. Its seq is 0 before the first one. */
HAPTIC_API int haptic_newest_state(haptic_session* session, haptic_state* state,
                                   haptic_error* error);
/* Waits for a state newer than the last one that this call gave, up to timeout_ms. */
HAPTIC_API int haptic_wait_for_state(haptic_session* session, uint32_t timeout_ms,
                                     haptic_state* state, haptic_error* error);

/* Where the proxy is now. publish never waits for the network; the newest sample wins. It is taken
 * to be computed from the last state that this session gave you. x has `count` values, one per
 * coordinate of the device. A coordinate in which a held proxy is that state's x_probe follows the
 * probe, as if free, unless the sample before held it at the same value. Force begins with a held
 * proxy only after a free one. */
HAPTIC_API int haptic_publish_free(haptic_session* session, haptic_error* error);
HAPTIC_API int haptic_publish_held(haptic_session* session, const double* x, size_t count,
                                   haptic_error* error);
/* The server keeps the probe out of the planes at 1 kHz. x is the point at which they are
 * linearised; if any plane has an id, x is the simulation's own proxy. Every plane has the size
 * planes[0].size. The library takes up to 1024 planes and sends the 32 deepest. A plane_count of 0,
 * with planes NULL, says that nothing is in the way. */
HAPTIC_API int haptic_publish_planes(haptic_session* session, const double* x, size_t count,
                                     const haptic_plane* planes, size_t plane_count,
                                     haptic_error* error);

/* Asks for force once; HAPTIC_ERROR_NOT_READY says what is missing. */
HAPTIC_API int haptic_engage(haptic_session* session, haptic_error* error);
/* Asks for force in the background until the server agrees; not after a fault. */
HAPTIC_API int haptic_engage_when_ready(haptic_session* session, haptic_error* error);
/* Why haptic_engage_when_ready() has no force yet, or gave up; HAPTIC_NOTHING: the server agreed,
 * or has not answered yet. */
HAPTIC_API int haptic_engage_refusal(haptic_session* session, haptic_error* error);
/* Gives force up; it fades out. */
HAPTIC_API int haptic_release(haptic_session* session, haptic_error* error);
/* applied: NULL, or what is in force now. */
HAPTIC_API int haptic_update(haptic_session* session, const haptic_settings* wanted,
                             haptic_settings* applied, haptic_error* error);

/* The oldest event that was not taken yet, or HAPTIC_NOTHING. Never waits. */
HAPTIC_API int haptic_next_event(haptic_session* session, haptic_event* event, haptic_error* error);
HAPTIC_API int haptic_statistics_of(haptic_session* session, haptic_statistics* statistics,
                                    haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif
