/* A wall on the first coordinate: it may not pass 0.314 rad. The wall is a plane, so the server
 * keeps the probe behind it at 1 kHz. Runs for SECONDS (default: 60).
 *
 *   haptic-example-c-virtual-wall [ADDRESS [SECONDS]] */
#include <haptic/haptic.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char** argv) {
  const haptic_connect_options server = {.size = sizeof server,
                                         .address = argc > 1 ? argv[1] : "127.0.0.1:29470"};
  const haptic_session_options options = {
      .size = sizeof options, .nominal_rate_hz = 200, .state_rate_hz = 200, .re_engage = 1};
  haptic_connection* connection = NULL;
  haptic_session* session = NULL;
  haptic_error error = {.size = sizeof error};
  haptic_state state = {.size = sizeof state};
  haptic_plane wall = {.size = sizeof wall, .normal = {1.0}, .offset = 0.314};
  int left = 200 * (argc > 2 ? atoi(argv[2]) : 60);
  int code = haptic_connect(&server, &connection, &error);
  if (code == HAPTIC_OK) code = haptic_open(connection, &options, &session, &error);
  if (code == HAPTIC_OK) code = haptic_engage_when_ready(session, &error);
  while (code == HAPTIC_OK && left-- > 0) {
    code = haptic_wait_for_state(session, 1000, &state, &error);
    if (code != HAPTIC_OK) break;
    code =
        haptic_publish_planes(session, state.x_probe.value, state.x_probe.count, &wall, 1, &error);
  }
  if (code != HAPTIC_OK) fprintf(stderr, "%s\n", error.message);
  printf("state %d, force %.3f\n", (int)state.state, state.tau_a.value[0]);
  haptic_close(session);
  haptic_disconnect(connection);
  return code == HAPTIC_OK ? 0 : 1;
}
