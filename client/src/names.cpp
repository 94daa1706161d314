#include "haptic/client/types.hpp"
#include "haptic/schema/fields.hpp"
#include "haptic/v1/session.pb.h"

namespace haptic::client {
namespace {

/// 0 says nothing; a value without a name is of a newer server.
template <typename Enum>
const char* name_of(const google::protobuf::EnumDescriptor* type, Enum value) noexcept {
  const char* const known = schema::value_name(*type, static_cast<int>(value));
  return known == nullptr || value == Enum{} ? "UNKNOWN" : known;
}

std::vector<std::string> names_of(int field, std::uint32_t bits) {
  return schema::bit_names(*v1::DeviceState::descriptor()->FindFieldByNumber(field), bits);
}

}  // namespace

std::vector<std::string> fault_names(std::uint32_t faults) {
  return names_of(v1::DeviceState::kFaultsFieldNumber, faults);
}

std::vector<std::string> limiter_names(std::uint32_t limiters) {
  return names_of(v1::DeviceState::kLimitersFieldNumber, limiters);
}

const char* name(Lifecycle state) noexcept {
  return name_of(v1::DeviceStateName_descriptor(), state);
}

const char* name(Staleness staleness) noexcept {
  return name_of(v1::StalenessLevel_descriptor(), staleness);
}

const char* name(Carrier carrier) noexcept {
  return name_of(v1::Transport_descriptor(), carrier);
}

}  // namespace haptic::client
