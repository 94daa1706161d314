/* For datagrams.py: the wall clock as hapticd sees it steps forward by 5 s as soon as the file
 * $HAPTIC_STEP exists. The three datagrams after that carry the kernel's stamp of before. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static atomic_int looked, stepped, late = 3;

static long step(void) {
  if (!stepped && atomic_fetch_add(&looked, 1) % 16 == 0) {
    const char* const trigger = getenv("HAPTIC_STEP");
    stepped = trigger != NULL && access(trigger, F_OK) == 0;
  }
  return stepped ? 5 : 0;
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  static int (*real)(clockid_t, struct timespec*);
  if (real == NULL) real = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  const int result = real(clock, now);
  if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += stepped ? 5 : 0;
  return result;
}

ssize_t recvmsg(int socket, struct msghdr* message, int flags) {
  static ssize_t (*real)(int, struct msghdr*, int);
  if (real == NULL) real = (ssize_t(*)(int, struct msghdr*, int))dlsym(RTLD_NEXT, "recvmsg");
  const ssize_t size = real(socket, message, flags);
  if (size < 0) return size;
  for (struct cmsghdr* c = CMSG_FIRSTHDR(message); c != NULL; c = CMSG_NXTHDR(message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    struct timespec stamp;
    memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    const long by = step();
    stamp.tv_sec += by != 0 && atomic_fetch_sub(&late, 1) > 0 ? 0 : by;
    memcpy(CMSG_DATA(c), &stamp, sizeof stamp);
  }
  return size;
}
