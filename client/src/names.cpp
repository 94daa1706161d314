#include "haptic/client/client.hpp"

namespace haptic::client {

const char* name(State state) noexcept {
  switch (state) {
    case State::kInit:
      return "INIT";
    case State::kIdle:
      return "IDLE";
    case State::kArmed:
      return "ARMED";
    case State::kEngaging:
      return "ENGAGING";
    case State::kEngaged:
      return "ENGAGED";
    case State::kReleasing:
      return "RELEASING";
    case State::kFault:
      return "FAULT";
    case State::kClosing:
      return "CLOSING";
    case State::kUnknown:
      break;
  }
  return "UNKNOWN";
}

const char* name(Staleness staleness) noexcept {
  switch (staleness) {
    case Staleness::kFresh:
      return "FRESH";
    case Staleness::kHold:
      return "HOLD";
    case Staleness::kFade:
      return "FADE";
    case Staleness::kLost:
      return "LOST";
    case Staleness::kUnknown:
      break;
  }
  return "UNKNOWN";
}

const char* name(Transport transport) noexcept {
  switch (transport) {
    case Transport::kGrpc:
      return "GRPC";
    case Transport::kUdp:
      return "UDP";
    case Transport::kUnknown:
      break;
  }
  return "UNKNOWN";
}

}  // namespace haptic::client
