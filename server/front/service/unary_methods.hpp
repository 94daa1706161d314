#pragma once
/// The unary calls by name, for carriers that bring their messages as bytes.

#include <google/protobuf/message.h>

#include <memory>
#include <string_view>

#include "server/front/service/calls.hpp"

namespace haptic::server {

/// The messages of a call; they live until it is answered.
struct UnaryCall {
  std::unique_ptr<google::protobuf::Message> request{};
  std::unique_ptr<google::protobuf::Message> response{};
  bool readable{true};  ///< its request was; only a stop may run if not
};

struct UnaryMethod {
  std::string_view name;
  bool observer;  ///< whether an observer may
  void (*make)(UnaryCall& call);
  void (*run)(Calls& calls, const UnaryCall& call, const Reply& reply);
};

inline constexpr std::string_view kStop = "EmergencyStop";

/// `name`: in HapticService. Null: it has no such unary call.
[[nodiscard]] const UnaryMethod* find_method(std::string_view name);

}  // namespace haptic::server
