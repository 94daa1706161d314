/* The part of haptic.h that is C's own, against a hapticd that serves finger_constant: structs and
 * room that the caller gives, wrong arguments, which are errors and no crash, and when handles end.
 * The Python package calls every other function: tests/client/python.
 *
 *   session_test ADDRESS */
#define _POSIX_C_SOURCE 200809L
#include <haptic/haptic.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static haptic_error error = {.size = sizeof error};

#define CHECK(what)                                                                            \
  do {                                                                                         \
    if (!(what)) {                                                                             \
      fprintf(stderr, "%s:%d: not %s; last: %d '%s'\n", __FILE__, __LINE__, #what, error.code, \
              error.message);                                                                  \
      exit(1);                                                                                 \
    }                                                                                          \
  } while (0)
#define REFUSED(call, text) \
  CHECK((call) == HAPTIC_ERROR_INVALID_ARGUMENT && strstr(error.message, text) != NULL)

static haptic_connection* connect_to(const char* address) {
  haptic_connect_options options = {.size = sizeof options, .address = address};
  haptic_connection* connection = NULL;
  CHECK(haptic_connect(&options, &connection, &error) == HAPTIC_OK && connection != NULL);
  return connection;
}

static haptic_session* open_session(haptic_connection* connection, const char* name) {
  haptic_session_options options = {
      .size = sizeof options, .client_name = name, .nominal_rate_hz = 200, .state_rate_hz = 200};
  haptic_session* session = NULL;
  CHECK(haptic_open(connection, &options, &session, &error) == HAPTIC_OK && session != NULL);
  return session;
}

/* No handle, nowhere to write, a size that is none. */
static void test_wrong_arguments(haptic_connection* connection, haptic_session* session) {
  haptic_connect_options options = {.size = sizeof options, .address = NULL};
  haptic_session_options opening = {.size = sizeof opening};
  haptic_connection* made = NULL;
  haptic_session* opened = NULL;
  haptic_state state = {.size = sizeof state};
  haptic_device device = {.size = sizeof device};
  double x[2] = {0.5, 0.5};
  size_t count = 7;
  REFUSED(haptic_connect(NULL, &made, &error), "options is NULL");
  REFUSED(haptic_connect(&options, NULL, &error), "connection is NULL");
  REFUSED(haptic_connect(&options, &made, &error), "options->address is NULL");
  options = (haptic_connect_options){
      .size = sizeof options, .address = "127.0.0.1:1", .tls = 1, .ca_file = "no/such.pem"};
  REFUSED(haptic_connect(&options, &made, &error), "no/such.pem");
  CHECK(made == NULL);
  REFUSED(haptic_open(connection, NULL, &opened, &error), "options is NULL");
  REFUSED(haptic_open(connection, &opening, NULL, &error), "session is NULL");
  opening.priority = 4;
  REFUSED(haptic_open(connection, &opening, &opened, &error), "options->priority = 4");
  opening.priority = 0;
  opening.carriers = 3;
  REFUSED(haptic_open(connection, &opening, &opened, &error), "options->carriers = 3");
  opening.carriers = 0;
  opening.block_count = 1;
  REFUSED(haptic_open(connection, &opening, &opened, &error), "options->blocks is NULL");
  opening.block_count = 0;
  CHECK(haptic_open(NULL, &opening, &opened, &error) == HAPTIC_ERROR_CLOSED);
  REFUSED(haptic_devices(connection, &device, 1, NULL, &error), "count is NULL");
  REFUSED(haptic_devices(connection, NULL, 1, &count, &error), "devices is NULL");
  CHECK(count == 0);

  REFUSED(haptic_newest_state(session, NULL, &error), "state is NULL");
  state.size = 0;
  REFUSED(haptic_newest_state(session, &state, &error), "state->size = 0");
  state.size = SIZE_MAX;
  REFUSED(haptic_wait_for_state(session, 1, &state, &error), "state->size");
  REFUSED(haptic_publish_held(session, NULL, 2, &error), "x is NULL");
  REFUSED(haptic_publish_held(session, x, 3, &error), "count = 3, must be 2");
  REFUSED(haptic_publish_held(session, x, SIZE_MAX, &error), "must be 2");
  REFUSED(haptic_publish_planes(session, x, 2, NULL, 1, &error), "planes is NULL");
  REFUSED(haptic_publish_planes(session, x, 2, NULL, SIZE_MAX, &error), "at most 1024");
  x[1] = (double)NAN;
  REFUSED(haptic_publish_held(session, x, 2, &error), "x[1] = nan");
  REFUSED(haptic_update(session, NULL, NULL, &error), "wanted is NULL");
  REFUSED(haptic_next_event(session, NULL, &error), "event is NULL");
  REFUSED(haptic_statistics_of(session, NULL, &error), "statistics is NULL");
  REFUSED(haptic_device_of(session, NULL, &error), "device is NULL");
  REFUSED(haptic_publish(session, NULL, &error), "proxy is NULL");
  REFUSED(haptic_publish(session, &(haptic_proxy){.size = sizeof(haptic_proxy)}, &error),
          "proxy->mode = 0");
  REFUSED(haptic_publish_pose(session, NULL, &error), "pose is NULL");
  REFUSED(haptic_publish_pose(session, &(haptic_pose){.size = sizeof(haptic_pose)}, &error),
          "only a session with `tracker`");
  REFUSED(haptic_server(connection, NULL, &error), "info is NULL");
  haptic_contact contact = {.size = sizeof contact, .point = {.size = 4 * sizeof contact.point}};
  haptic_plane plane = {.size = sizeof plane};
  REFUSED(haptic_contact_at(x, 2, &contact, 1.0, &plane, &error), "contact->point->size");
  REFUSED(haptic_health(connection, NULL, NULL, &error), "healthy is NULL");
  CHECK((void*)connection != (void*)session);
  CHECK(haptic_publish_held((haptic_session*)connection, x, 2, NULL) == HAPTIC_ERROR_CLOSED);
  CHECK(haptic_newest_state((haptic_session*)x, NULL, NULL) == HAPTIC_ERROR_CLOSED);
}

static void test_sizes_of_planes(haptic_session* session) {
  const double x[2] = {0.5, 0.5};
  haptic_plane planes[2] = {{.size = sizeof planes[0]}, {.size = 8}};
  haptic_settings settings = {.size = sizeof settings, .stiffness = {.count = 25}};
  REFUSED(haptic_publish_planes(session, x, 2, planes, 2, &error), "planes[1].size = 8");
  planes[1] = planes[0];
  planes[1].curvature_count = 37;
  REFUSED(haptic_publish_planes(session, x, 2, planes, 2, &error), "curvature_count = 37");
  REFUSED(haptic_update(session, &settings, NULL, &error), "stiffness.count = 25");
  settings = (haptic_settings){.size = sizeof settings, .renderer = -1};
  REFUSED(haptic_update(session, &settings, NULL, &error), "renderer = -1");
}

/* A program that was compiled with a later header, whose structs are longer. */
static void test_longer_structs(haptic_connection* connection, haptic_session* session) {
  struct {
    haptic_state state;
    double later[2];
  } longer = {.state = {.size = sizeof longer}, .later = {1.0, 2.0}};
  struct {
    haptic_session_options options;
    double later;
  } wish = {.options = {.size = sizeof wish, .observer = 1}, .later = 3.0};
  haptic_session* opened = NULL;
  CHECK(haptic_wait_for_state(session, 10000, &longer.state, &error) == HAPTIC_OK);
  CHECK(longer.state.seq > 0 && longer.state.size == sizeof longer);
  CHECK(longer.later[0] == 0.0 && longer.later[1] == 0.0);
  REFUSED(haptic_open(connection, &wish.options, &opened, &error), "does not know");
  wish.later = 0.0;
  CHECK(haptic_open(connection, &wish.options, &opened, &error) == HAPTIC_OK);
  CHECK(haptic_close(opened) == HAPTIC_OK);
}

static void test_devices(haptic_connection* connection, haptic_session* session) {
  haptic_device device[2] = {{.size = sizeof device[0]}};
  size_t count = 0;
  CHECK(haptic_devices(connection, NULL, 0, &count, &error) == HAPTIC_OK && count == 1);
  CHECK(haptic_devices(connection, device, 2, &count, &error) == HAPTIC_OK && count == 1);
  CHECK(strcmp(device[0].controller, "in C") == 0 && device[1].size == 0);
  device[1].size = sizeof device[1];
  CHECK(haptic_device_of(session, &device[1], &error) == HAPTIC_OK);
  CHECK(strcmp(device[1].coordinates[1].name, device[0].coordinates[1].name) == 0);
}

static void test_server(haptic_connection* connection) {
  haptic_server_info info = {.size = sizeof info};
  int32_t healthy = -1;
  CHECK(haptic_server(connection, &info, &error) == HAPTIC_OK);
  CHECK(strcmp(info.version, haptic_version()) == 0 && info.realtime.grade[0] != 0);
  CHECK(strcmp(info.scene, "one finger at rest") == 0);
  CHECK(haptic_health(connection, NULL, &healthy, &error) == HAPTIC_OK && healthy >= 0);
  CHECK(haptic_health(connection, "glove", &healthy, &error) == HAPTIC_ERROR_NO_SUCH_DEVICE);
}

/* A spring of 300 N/m that begins at x[0] = 0.1, as `user` contacts of the same. */
static int64_t springs(const double* x, size_t count, haptic_contact* contacts, size_t capacity,
                       void* user) {
  const int64_t wanted = *(const int64_t*)user;
  CHECK(count == 3);
  for (int64_t i = 0; i < wanted && i < (int64_t)capacity; ++i) {
    CHECK(haptic_point_itself(x, count, 0, &contacts[i].point, NULL) == HAPTIC_OK);
    contacts[i].normal[0] = -1.0;
    contacts[i].gap = 0.1 - x[0];
    contacts[i].stiffness = 300.0 / (double)wanted;
    contacts[i].id = (uint32_t)(i + 1);
  }
  return wanted;
}

static void test_solve(void) {
  const double probe[3] = {0.5, 0.2, 0.0}, start[3] = {0.0, 0.2, 0.0};
  const haptic_solve_options options = {.size = sizeof options, .start = start};
  haptic_solution found = {.size = sizeof found};
  haptic_plane planes[2] = {{.size = sizeof planes[0]}};
  int64_t many = 1;
  for (int turn = 0; turn < 2; ++turn, many = 40) {
    CHECK(haptic_solve(springs, &many, probe, 3, 100.0, &options, &found, planes, 2, &error) ==
          HAPTIC_OK);
    /* 100 (x - 0.5) + 300 (x - 0.1) = 0 */
    CHECK(found.converged == 1 && found.x.count == 3 && fabs(found.x.value[0] - 0.2) < 1e-9);
    CHECK(found.x.value[1] == 0.2 && found.plane_count == (size_t)many);
    CHECK(planes[0].id == 1 && fabs(planes[0].offset - 0.1) < 1e-12);
  }
  many = -5;
  REFUSED(haptic_solve(springs, &many, probe, 3, 100.0, NULL, &found, NULL, 0, &error), "gave up");
  many = 1025;
  REFUSED(haptic_solve(springs, &many, probe, 3, 100.0, NULL, &found, NULL, 0, &error),
          "returned 1025");
  REFUSED(haptic_solve(NULL, NULL, probe, 3, 1.0, NULL, &found, NULL, 0, &error),
          "contacts is NULL");
  REFUSED(haptic_solve(springs, &many, probe, 3, 0.0, NULL, &found, NULL, 0, &error), "coupling");
}

static void test_wrong_contacts(void) {
  const double x[2] = {0.1, 0.2}, lengths[1] = {0.045};
  haptic_point point = {.size = sizeof point};
  haptic_contact contact = {.size = sizeof contact};
  haptic_plane plane = {.size = sizeof plane};
  REFUSED(haptic_point_itself(x, 2, 0, &point, &error), "must lie within the 2 of x");
  REFUSED(haptic_point_on_pose(x, 2, NULL, 0, &point, &error), "offset is NULL");
  REFUSED(haptic_point_on_finger(lengths, 1, x, 2, 2, 0, 0, 0, &point, &error), "length_count = 1");
  REFUSED(haptic_point_on_finger(lengths, 1, x, 2, 9, 0, 0, 0, &point, &error), "phalanx + 1 = 10");
  REFUSED(haptic_point_on_joints(NULL, 1, contact.normal, 0, &point, &error), "joints is NULL");
  REFUSED(haptic_point_on_joints(NULL, 9, contact.normal, 0, &point, &error), "joint_count = 9");
  REFUSED(haptic_sphere_curvature(contact.normal, 0.0, contact.curvature, &error), "distance = 0");
  REFUSED(haptic_contact_at(x, 2, &contact, 0.02, &plane, &error), "contact->point->size = 0");
  contact.point.size = sizeof contact.point;
  contact.point.count = 9;
  REFUSED(haptic_contact_at(x, 2, &contact, 0.02, &plane, &error), "point.count = 9");
  contact.point.count = 1;
  REFUSED(haptic_contact_at(x, 2, &contact, 0.0, &plane, &error), "coupling = 0");
  contact.object_direction_count = 7;
  REFUSED(haptic_contact_at(x, 2, &contact, 1.0, &plane, &error), "object_direction_count = 7");
}

/* Publishes at each state until the lifecycle is `wanted`; at most 20 s. `beyond`: how far the
 * proxy is held from the probe, if there is force; else the proxy is free. */
static haptic_state publish_until(haptic_session* session, int wanted, double beyond) {
  haptic_state state = {.size = sizeof state};
  double x[2] = {0.0, 0.0};
  for (int i = 0; i < 4000; ++i) {
    CHECK(haptic_wait_for_state(session, 10000, &state, &error) == HAPTIC_OK);
    if (state.state == wanted && (beyond == 0.0 || fabs(state.tau_a.value[0]) > 0.1)) return state;
    x[0] = state.x_probe.value[0] + beyond;
    x[1] = state.x_probe.value[1];
    CHECK((state.gain > 0.0 ? haptic_publish_held(session, x, state.x_probe.count, &error)
                            : haptic_publish_free(session, &error)) == HAPTIC_OK);
  }
  CHECK(!"the lifecycle that was waited for");
  return state;
}

static void test_force(haptic_session* session) {
  haptic_state state = {.size = sizeof state};
  haptic_plane wall = {.size = sizeof wall, .normal = {1.0, 0.0}};
  CHECK(haptic_engage_when_ready(session, &error) == HAPTIC_OK);
  publish_until(session, HAPTIC_ENGAGED, 0.01);
  CHECK(haptic_engage_refusal(session, &error) == HAPTIC_NOTHING);
  for (int i = 0; i < 4000 && (state.active_planes & 1U) == 0; ++i) {
    CHECK(haptic_wait_for_state(session, 10000, &state, &error) == HAPTIC_OK);
    wall.offset = state.x_probe.value[0] - 0.005;
    CHECK(haptic_publish_planes(session, state.x_probe.value, 2, &wall, 1, &error) == HAPTIC_OK);
  }
  CHECK((state.active_planes & 1U) == 1U && state.mode == HAPTIC_PLANES);
  CHECK(haptic_release(session, &error) == HAPTIC_OK);
}

/* Names go into the room that there is, and an event that is none leaves nothing behind. */
static void test_emergency_stop(haptic_connection* connection, haptic_session* session) {
  haptic_event event = {.size = sizeof event};
  haptic_state state = {.size = sizeof state};
  char names[64] = "none";
  CHECK(haptic_emergency_stop(connection, NULL, "a test in C", names, 3, &error) == HAPTIC_OK);
  CHECK(names[0] == 0); /* no room for a whole name */
  CHECK(haptic_emergency_stop(connection, NULL, "a test in C", names, sizeof names, &error) ==
        HAPTIC_OK);
  CHECK(strcmp(names, "finger") == 0);
  for (int told = 0; !told;) {
    CHECK(haptic_wait_for_state(session, 10000, &state, &error) == HAPTIC_OK);
    while (haptic_next_event(session, &event, &error) == HAPTIC_OK) {
      told = told || strcmp(event.reason, "EMERGENCY_STOP") == 0;
    }
  }
  CHECK(event.reason[0] == 0);
  CHECK(haptic_clear_fault(connection, "finger", 0, NULL, &error) == HAPTIC_OK);
}

static void* wait_until_closed(void* session) {
  haptic_state state = {.size = sizeof state};
  int code = HAPTIC_OK;
  while (code == HAPTIC_OK || code == HAPTIC_ERROR_TIMEOUT) {
    code = haptic_wait_for_state(session, 10000, &state, NULL);
  }
  return code == HAPTIC_ERROR_CLOSED ? session : NULL;
}

static void test_close_while_waiting(haptic_connection* connection, haptic_session* session) {
  haptic_state state = {.size = sizeof state};
  pthread_t waiter;
  void* closed = NULL;
  CHECK(pthread_create(&waiter, NULL, wait_until_closed, session) == 0);
  CHECK(haptic_disconnect(connection) == HAPTIC_OK);
  CHECK(haptic_disconnect(connection) == HAPTIC_ERROR_CLOSED);
  CHECK(haptic_wait_for_state(session, 10000, &state, &error) == HAPTIC_OK);
  CHECK(haptic_close(session) == HAPTIC_OK);
  CHECK(haptic_close(session) == HAPTIC_ERROR_CLOSED);
  CHECK(haptic_publish_free(session, &error) == HAPTIC_ERROR_CLOSED);
  CHECK(haptic_newest_state(session, &state, &error) == HAPTIC_ERROR_CLOSED);
  CHECK(pthread_join(waiter, &closed) == 0 && closed == session);
}

/* Asked by the leak sanitizer: without its parent's threads a child's memory looks lost. */
static int is_child;
int __lsan_is_turned_off(void);
int __lsan_is_turned_off(void) {
  return is_child;
}

/* A child may neither use nor end what its parent has, even while the parent's threads work. */
static void test_child(haptic_connection* connection, haptic_session* session,
                       const char* address) {
  haptic_state state = {.size = sizeof state};
  haptic_connect_options options = {.size = sizeof options, .address = address};
  haptic_connection* made = NULL;
  size_t count = 0;
  int status = -1;
  const pid_t child = fork();
  CHECK(child >= 0);
  if (child == 0) {
    is_child = 1;
    alarm(20); /* should exit() wait for the parent's threads */
    CHECK(haptic_publish_free(session, &error) == HAPTIC_ERROR_CLOSED);
    CHECK(strstr(error.message, "forked") != NULL);
    CHECK(haptic_newest_state(session, &state, &error) == HAPTIC_ERROR_CLOSED);
    CHECK(haptic_wait_for_state(session, 9000, &state, &error) == HAPTIC_ERROR_CLOSED);
    CHECK(haptic_release(session, &error) == HAPTIC_ERROR_CLOSED);
    CHECK(haptic_devices(connection, NULL, 0, &count, &error) == HAPTIC_ERROR_CLOSED);
    CHECK(haptic_connect(&options, &made, &error) == HAPTIC_ERROR_CLOSED && made == NULL);
    CHECK(haptic_close(session) == HAPTIC_ERROR_CLOSED);
    CHECK(haptic_disconnect(connection) == HAPTIC_ERROR_CLOSED);
    exit(0);
  }
  CHECK(waitpid(child, &status, 0) == child && status == 0);
  for (int i = 0; i < 200; ++i) {
    CHECK(haptic_wait_for_state(session, 10000, &state, &error) == HAPTIC_OK);
    CHECK(haptic_publish_free(session, &error) == HAPTIC_OK);
  }
}

int main(int argc, char** argv) {
  CHECK(argc == 2);
  haptic_connection* connection = connect_to("127.0.0.1:1");
  size_t count = 0;
  CHECK(haptic_devices(connection, NULL, 0, &count, &error) == HAPTIC_ERROR_UNREACHABLE);
  CHECK(haptic_disconnect(connection) == HAPTIC_OK);
  connection = connect_to(argv[1]);
  haptic_session* session = open_session(connection, "in C");
  test_wrong_arguments(connection, session);
  test_sizes_of_planes(session);
  test_longer_structs(connection, session);
  test_devices(connection, session);
  test_server(connection);
  test_solve();
  test_wrong_contacts();
  test_child(connection, session, argv[1]);
  test_force(session);
  test_emergency_stop(connection, session);
  test_close_while_waiting(connection, session);
  open_session(connect_to(argv[1]), "not closed"); /* exit() ends it */
  return 0;
}
