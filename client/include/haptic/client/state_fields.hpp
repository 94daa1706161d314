#pragma once
/// The fields of a device's state by name, with their labels and units: for tables, logs and JSON
/// that show everything the server says.

#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

struct StateField {
  enum class Kind { kNumber, kName, kBits, kMessage };
  std::string name{};  ///< as in proto/haptic/v1/session.proto: "tau_a"
  Kind kind{Kind::kNumber};
  bool repeated{false};
  /// Things that the values of a repeated field belong to: "dof", "actuated" (DoFs) or
  /// "coordinate"; empty: nothing that has a name.
  std::string axis{};
  /// Per value: names of DoFs or virtual coordinates, in this order; empty without an axis.
  std::vector<std::string> labels{};
  /// Per label, or one without an axis: "N m/rad"; empty: none.
  std::vector<std::string> units{};
  /// kNumber: digits that read back to the same bits, or "nan"; kName: "ENGAGED"; kBits: names
  /// apart by '|'. Empty if the field is absent.
  std::vector<std::string> values{};
  /// kMessage: the fields of each message; one with empty values stands for an absent message.
  std::vector<std::vector<StateField>> messages{};
};

/// Every field that the protocol has, in its order, with the values of `state`.
[[nodiscard]] std::vector<StateField> state_fields(const DeviceInfo& device,
                                                   const DeviceState& state);

}  // namespace haptic::client
