/* The C library in lock-step: does what stdin says, a line each, and answers with a line.
 *
 *   lock_step_client ADDRESS
 *   free | held X... | engage | state      (numbers by their bits; state: its seq and tau_a) */
#include <haptic/haptic.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char** argv) {
  const haptic_connect_options server = {.size = sizeof server, .address = argv[argc - 1]};
  const haptic_session_options options = {.size = sizeof options,
                                          .client_name = "in C",
                                          .nominal_rate_hz = 100,
                                          .carriers = HAPTIC_STREAM_ONLY};
  haptic_error error = {.size = sizeof error};
  haptic_connection* connection = NULL;
  haptic_session* session = NULL;
  char line[4096];
  int code = haptic_connect(&server, &connection, &error);
  if (code == HAPTIC_OK) code = haptic_open(connection, &options, &session, &error);
  printf("%d %s\n", code, error.message);
  fflush(stdout);
  while (code == HAPTIC_OK && fgets(line, sizeof line, stdin) != NULL) {
    haptic_state state = {.size = sizeof state};
    double x[HAPTIC_MAX_COORDINATES];
    size_t count = 0;
    char* next = line + 4;
    if (strncmp(line, "free", 4) == 0) code = haptic_publish_free(session, &error);
    if (strncmp(line, "held", 4) == 0) {
      for (char* end = NULL; count < HAPTIC_MAX_COORDINATES; next = end) {
        const uint64_t bits = strtoull(next, &end, 16);
        if (end == next) break;
        memcpy(&x[count++], &bits, sizeof bits);
      }
      code = haptic_publish_held(session, x, count, &error);
    }
    if (strncmp(line, "engage", 6) == 0) code = haptic_engage(session, &error);
    if (strncmp(line, "state", 5) == 0) code = haptic_newest_state(session, &state, &error);
    uint64_t tau_a = 0;
    memcpy(&tau_a, &state.tau_a.value[0], sizeof tau_a);
    printf("%d %" PRIu64 " %" PRIx64 " %s\n", code, state.seq, tau_a, error.message);
    fflush(stdout);
  }
  haptic_close(session);
  haptic_disconnect(connection);
  return code == HAPTIC_OK ? 0 : 1;
}
