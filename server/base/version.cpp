#include "server/base/version.hpp"

namespace haptic::server {

const char* version() noexcept {
  return HAPTIC_VERSION;
}

}  // namespace haptic::server
