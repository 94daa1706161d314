#include "server/base/wake_up.hpp"

#include <sys/eventfd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::server {

WakeUp::WakeUp() : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!event_) throw core::TransportError(std::string("eventfd: ") + std::strerror(errno));
}

void WakeUp::wake() const noexcept {
  static_cast<void>(eventfd_write(event_.get(), 1));
}

void WakeUp::forget() const noexcept {
  eventfd_t count = 0;
  static_cast<void>(eventfd_read(event_.get(), &count));
}

}  // namespace haptic::server
