#include "convert.hpp"

#include "convert_state.hpp"
#include "google/protobuf/util/time_util.h"

namespace haptic::client {

using google::protobuf::util::TimeUtil;

DeviceState to_state(const v1::DeviceState& message) {
  DeviceState state;
  read(message, state);
  state.received = std::chrono::steady_clock::now();
  return state;
}

std::chrono::nanoseconds to_duration(const google::protobuf::Duration& message) {
  return std::chrono::nanoseconds(TimeUtil::DurationToNanoseconds(message));
}

void write(std::chrono::nanoseconds from, google::protobuf::Duration& to) {
  to = TimeUtil::NanosecondsToDuration(from.count());
}

}  // namespace haptic::client
