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
 *   One that waits says so, and for what; the others return at once. The library calls nothing of
 *   yours, but for what haptic_solve() gets, on the thread that calls it.
 * - After fork() only the parent may use its handles. In the child every function that takes a
 *   handle, and haptic_connect(), gives HAPTIC_ERROR_CLOSED; nothing is sent and nothing ends.
 * - Connections and sessions may be closed in any order. exit() without closing is allowed: it ends
 *   the sessions, and the server lets the force fade out.
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

/* The connections. A call that waits for the server's answer waits for 5 s at most. */

/* Returns at once, whether or not a server runs there. */
HAPTIC_API int haptic_connect(const haptic_connect_options* options, haptic_connection** connection,
                              haptic_error* error);
HAPTIC_API int haptic_disconnect(haptic_connection* connection);

/* Waits for the server's answer. */
HAPTIC_API int haptic_server(haptic_connection* connection, haptic_server_info* info,
                             haptic_error* error);
/* *healthy: 1 if the device is open and the 1 kHz loop is on time; device NULL: every device is.
 * Waits for the server's answer. */
HAPTIC_API int haptic_health(haptic_connection* connection, const char* device, int32_t* healthy,
                             haptic_error* error);
/* Fills up to `capacity` devices; devices[0].size must be set. *count: how many the server has.
 * Waits for the server's answer. */
HAPTIC_API int haptic_devices(haptic_connection* connection, haptic_device* devices,
                              size_t capacity, size_t* count, haptic_error* error);
/* Zero force at once, and the fault EMERGENCY_STOP until haptic_clear_fault(). device NULL: all of
 * them. reason: for the log, or NULL. stopped: NULL, or `stopped_size` bytes for the names of the
 * devices that are in FAULT now, a line each. Waits for the server's answer. */
HAPTIC_API int haptic_emergency_stop(haptic_connection* connection, const char* device,
                                     const char* reason, char* stopped, size_t stopped_size,
                                     haptic_error* error);
/* faults: bits of haptic_state.faults; 0: all that are active. *cleared (or NULL): those that
 * were. HAPTIC_ERROR_NOT_READY if the cause of one persists. Waits for the server's answer. */
HAPTIC_API int haptic_clear_fault(haptic_connection* connection, const char* device,
                                  uint32_t faults, uint32_t* cleared, haptic_error* error);

/* The sessions. A call that waits for the server's answer waits for timeout_ms of the options. */

/* Waits until the server agrees. HAPTIC_ERROR_LEASE_HELD: another controller has the device, with
 * the same priority or a higher one. */
HAPTIC_API int haptic_open(haptic_connection* connection, const haptic_session_options* options,
                           haptic_session** session, haptic_error* error);
/* Ends the session; calls that wait on other threads return HAPTIC_ERROR_CLOSED. A session that
 * reconnects waits up to 500 ms for the server to hear its farewell. */
HAPTIC_API int haptic_close(haptic_session* session);
/* The device as it was when the session opened. */
HAPTIC_API int haptic_device_of(haptic_session* session, haptic_device* device,
                                haptic_error* error);

/* Copies the newest state. Its seq is 0 before the first one. */
HAPTIC_API int haptic_newest_state(haptic_session* session, haptic_state* state,
                                   haptic_error* error);
/* Waits for a state newer than the last one that this call gave, up to timeout_ms. */
HAPTIC_API int haptic_wait_for_state(haptic_session* session, uint32_t timeout_ms,
                                     haptic_state* state, haptic_error* error);

/* Where the proxy is now. publish never waits for the network; the newest sample wins. It is taken
 * to be computed from the last state that this session gave you. x has `count` values, one per
 * coordinate of the device. A coordinate in which a held proxy is that state's x_probe follows the
 * probe, as if free, unless the sample before held it at the same value. Force begins with a held
 * proxy only after a free one. HAPTIC_ERROR_CLOSED says that the session ended; one that reconnects
 * goes on meanwhile. */
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
/* Any of these, computed from another state, or valid for a shorter time. */
HAPTIC_API int haptic_publish(haptic_session* session, const haptic_proxy* proxy,
                              haptic_error* error);
/* The same for a session with `tracker`: where the palm is now. */
HAPTIC_API int haptic_publish_pose(haptic_session* session, const haptic_pose* pose,
                                   haptic_error* error);

/* Asks for force once; HAPTIC_ERROR_NOT_READY says what is missing. Waits for the answer. */
HAPTIC_API int haptic_engage(haptic_session* session, haptic_error* error);
/* Asks for force in the background until the server agrees; not after a fault. */
HAPTIC_API int haptic_engage_when_ready(haptic_session* session, haptic_error* error);
/* Why haptic_engage_when_ready() has no force yet, or gave up; HAPTIC_NOTHING: the server agreed,
 * or has not answered yet. */
HAPTIC_API int haptic_engage_refusal(haptic_session* session, haptic_error* error);
/* Gives force up; it fades out. Waits for the server's answer, if the session has a stream. */
HAPTIC_API int haptic_release(haptic_session* session, haptic_error* error);
/* applied: NULL, or what is in force now. Waits for the server's answer. */
HAPTIC_API int haptic_update(haptic_session* session, const haptic_settings* wanted,
                             haptic_settings* applied, haptic_error* error);

/* The oldest event that was not taken yet, or HAPTIC_NOTHING. */
HAPTIC_API int haptic_next_event(haptic_session* session, haptic_event* event, haptic_error* error);
HAPTIC_API int haptic_statistics_of(haptic_session* session, haptic_statistics* statistics,
                                    haptic_error* error);

/* Contacts for a simulation that knows its own geometry: where a point of the tool is, how near an
 * object is to it, and how that object gives way. These functions take no handle. Vectors are in
 * any one frame that the point, the normal and the curvature share and that does not move with the
 * coordinates. x: `count` coordinates; the point's begin at first_coordinate. */

/* A point of a planar finger (MCP, PIP), rad: `along` phalanx number `phalanx` from its joint, and
 * `palmar` of its line, m. Frame: origin on the first axis, +x distal, +y dorsal; at 0 all
 * phalanges lie along +x, and flexion turns them to -y. lengths: of the phalanges before it, m. */
HAPTIC_API int haptic_point_on_finger(const double* lengths, size_t length_count, const double* x,
                                      size_t count, uint32_t phalanx, double along, double palmar,
                                      uint32_t first_coordinate, haptic_point* point,
                                      haptic_error* error);
/* position: on the last link of a chain of up to 8 joints, from the base on. */
HAPTIC_API int haptic_point_on_joints(const haptic_joint* joints, size_t joint_count,
                                      const double position[3], uint32_t first_coordinate,
                                      haptic_point* point, haptic_error* error);
/* The coordinates are x, y, z of the point itself, m. */
HAPTIC_API int haptic_point_itself(const double* x, size_t count, uint32_t first_coordinate,
                                   haptic_point* point, haptic_error* error);
/* The coordinates are a frame's x, y, z, m, and its quaternion qx, qy, qz, qw. offset: of the point
 * in that frame, m. */
HAPTIC_API int haptic_point_on_pose(const double* x, size_t count, const double offset[3],
                                    uint32_t first_coordinate, haptic_point* point,
                                    haptic_error* error);
/* Second derivative of the gap by the point, 1/m: xx, yx, yy, zx, zy, zz. distance: of the point
 * from the centre or the axis (of length 1), m, not 0; < 0: it is inside a hollow one. */
HAPTIC_API int haptic_sphere_curvature(const double normal[3], double distance, double curvature[6],
                                       haptic_error* error);
HAPTIC_API int haptic_cylinder_curvature(const double normal[3], const double axis[3],
                                         double distance, double curvature[6], haptic_error* error);
/* The contact as the server takes it, linearised at x. coupling: c of the simulation's own
 * coupling, whose energy is c/2 |x - x_probe|^2: N/m if x is in m, N m/rad if in rad. */
HAPTIC_API int haptic_contact_at(const double* x, size_t count, const haptic_contact* contact,
                                 double coupling, haptic_plane* plane, haptic_error* error);
/* The contact with this gap and gradient of the gap at x; you add the other fields. */
HAPTIC_API int haptic_contact_of_gap(const double* x, const double* gradient, size_t count,
                                     double gap, haptic_plane* plane, haptic_error* error);
/* Contacts with a gap up to this, m, should be told before they are touched: v_max (round trip +
 * period). round_trip_ns: of haptic_statistics; 0: 200 ms. v_max: m/s; 0: 0.5, fast for a finger.
 */
HAPTIC_API double haptic_contact_horizon(int64_t round_trip_ns, int64_t period_ns, double v_max);
/* One plane per block, through the proxy x and with the normal x_probe - x; a block whose proxy is
 * within `least` (m or rad) of its probe has none. blocks NULL: all coordinates are one. Fills up
 * to `capacity` planes; planes[0].size must be set. *plane_count: how many there are. */
HAPTIC_API int haptic_derive_planes(const haptic_coordinate* coordinates, const double* x,
                                    const double* x_probe, size_t count, const haptic_block* blocks,
                                    size_t block_count, double least, haptic_plane* planes,
                                    size_t capacity, size_t* plane_count, haptic_error* error);

/* The proxy of a simulation that has contacts and no solver of its own: the x near options->start
 * that minimises coupling / 2 |x - x_probe|^2 + stiffness / 2 sum of gap^2 over what is touched,
 * with gap >= 0 where a contact is rigid. It asks `contacts` for the contacts at one x after
 * another, 5 to 20 times as a rule, at most 1024 each time. planes: what to publish with x, of
 * which it fills up to `capacity`; planes[0].size must be set. options: NULL for the default. */
HAPTIC_API int haptic_solve(haptic_contacts_at contacts, void* user, const double* x_probe,
                            size_t count, double coupling, const haptic_solve_options* options,
                            haptic_solution* solution, haptic_plane* planes, size_t capacity,
                            haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif
