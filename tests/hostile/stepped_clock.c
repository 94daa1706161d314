/* For datagrams.py: the wall clock as hapticd sees it steps forward by 5 s, $HAPTIC_STEP_AFTER
 * seconds after the program began. Three datagrams then carry the kernel's stamp of before, as
 * those do that were under way. Says so on standard error. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static atomic_int late = 3;
static atomic_bool stepped;
static time_t step_at;

static int real_gettime(clockid_t clock, struct timespec* now) {
  static int (*real)(clockid_t, struct timespec*);
  if (real == NULL) real = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  return real(clock, now);
}

__attribute__((constructor)) static void begin(void) {
  struct timespec now;
  const char* const after = getenv("HAPTIC_STEP_AFTER");
  if (after == NULL || real_gettime(CLOCK_MONOTONIC, &now) != 0) return;
  step_at = now.tv_sec + atoi(after);
}

/* Looks at a datagram that came whether the time has come. */
static bool look(void) {
  struct timespec now;
  if (!stepped && step_at != 0 && real_gettime(CLOCK_MONOTONIC, &now) == 0 &&
      now.tv_sec >= step_at && !atomic_exchange(&stepped, true)) {
    static const char kSaid[] = "stepped_clock: 5 s forward\n";
    if (write(STDERR_FILENO, kSaid, sizeof kSaid - 1) < 0) return true;
  }
  return stepped;
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int result = real_gettime(clock, now);
  if (result == 0 && clock == CLOCK_REALTIME && stepped) now->tv_sec += 5;
  return result;
}

ssize_t recvmsg(int socket, struct msghdr* message, int flags) {
  static ssize_t (*real)(int, struct msghdr*, int);
  if (real == NULL) real = (ssize_t(*)(int, struct msghdr*, int))dlsym(RTLD_NEXT, "recvmsg");
  const ssize_t size = real(socket, message, flags);
  if (size < 0) return size;
  for (struct cmsghdr* c = CMSG_FIRSTHDR(message); c != NULL; c = CMSG_NXTHDR(message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    if (!look() || atomic_fetch_sub(&late, 1) > 0) continue;
    struct timespec stamp;
    memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    stamp.tv_sec += 5;
    memcpy(CMSG_DATA(c), &stamp, sizeof stamp);
  }
  if (size >= 32) look(); /* also if there is no stamp to change */
  return size;
}

ssize_t recvfrom(int socket, void* buffer, size_t size, int flags, struct sockaddr* from,
                 socklen_t* length) {
  static ssize_t (*real)(int, void*, size_t, int, struct sockaddr*, socklen_t*);
  if (real == NULL) {
    real = (ssize_t(*)(int, void*, size_t, int, struct sockaddr*, socklen_t*))dlsym(RTLD_NEXT,
                                                                                    "recvfrom");
  }
  const ssize_t received = real(socket, buffer, size, flags, from, length);
  if (received >= 32) look();
  return received;
}
