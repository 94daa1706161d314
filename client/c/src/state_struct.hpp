#pragma once
/// The structs of a state, a device and the server: filled by what is made of the messages' fields
/// (proto/generate).

#include "haptic/client/facts.hpp"
#include "haptic/client/state.hpp"
#include "structs.hpp"

namespace haptic::c {

// `to` is all 0.
void write(const client::DeviceState& from, haptic_state& to);
void write(const client::DeviceInfo& from, haptic_device& to);
void write(const client::ServerInfo& from, haptic_server_info& to);

template <typename Struct, typename Value>
[[nodiscard]] Struct to_struct(const Value& value) {
  Struct to{};
  write(value, to);
  return to;
}

}  // namespace haptic::c
