#pragma once
/// What happens to the device and to the session, in words.

#include <cstdio>

#include "haptic/client/session.hpp"

namespace haptic::examples {

inline void print_event(const client::Event& event) {
  std::fprintf(stderr, "%s: %s\n", event.reason.c_str(), event.message.c_str());
}

inline void print_end(const client::ClientError& error, bool will_retry) {
  std::fprintf(stderr, "the session ended: %s%s\n", error.what(),
               will_retry ? "; trying again" : "");
}

}  // namespace haptic::examples
