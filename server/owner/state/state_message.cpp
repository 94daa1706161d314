#include "server/owner/state/state_message.hpp"

#include <algorithm>

#include "haptic/core/error.hpp"
#include "haptic/schema/fields.hpp"

namespace haptic::server {
namespace {

/// Bytes of one value at most.
std::size_t largest_value(const google::protobuf::FieldDescriptor& field) {
  using google::protobuf::FieldDescriptor;
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) return 8;
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) return 1;
  const std::string& bits = field.options().GetExtension(v1::bits);
  if (!bits.empty()) {
    const auto count = std::count(bits.begin(), bits.end(), ' ') + 1;
    return static_cast<std::size_t>(count + 6) / 7;  // 7 bits per byte of a varint
  }
  return field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32 ? 5 : 10;
}

}  // namespace

void serialise(const core::TickRecord& record, const v1::DeviceState& state, SerialisedState& to) {
  to.size = static_cast<std::uint32_t>(state.ByteSizeLong());
  if (to.size > SerialisedState::kMost) to.size = 0;  // Owner::add() refused such a device
  to.tenure = record.input.command.tenure;
  to.tick = record.beat.tick;
  to.now = record.input.now;
  to.proxy_age = record.proxy.age;
  to.lease_held = record.input.command.lease_held;
  to.proxy_used = record.proxy.mode != core::ProxyMode::kNone;
  if (to.size > 0) state.SerializeWithCachedSizesToArray(to.bytes.data());
}

std::size_t largest_state(const core::PipelineConfig& config) {
  const core::DofLayout& layout = config.kinematics->layout();
  const auto values = [&](v1::Axis axis) {
    if (axis == v1::AXIS_DOF) return layout.n_q();
    if (axis == v1::AXIS_ACTUATED) return layout.n_a();
    return axis == v1::AXIS_COORDINATE ? config.kinematics->space().n_x() : 1;
  };
  const auto absent = [&](int field) {
    return (field == v1::DeviceState::kPassivityFieldNumber && !config.passivity.enabled()) ||
           (field == v1::DeviceState::kTrackerFieldNumber && !config.tracker) ||
           (field == v1::DeviceState::kTemperatureCFieldNumber && config.ratings.empty());
  };
  std::size_t bytes = 0;
  for (const schema::Leaf& leaf : schema::leaves(*v1::DeviceState::descriptor())) {
    const auto& outer = leaf.parent == nullptr ? *leaf.field : *leaf.parent;
    if (absent(outer.number())) continue;
    const bool alone = leaf.parent == nullptr && !leaf.field->is_repeated();
    const std::size_t tag_and_length = alone ? 2 : 4;
    bytes +=
        tag_and_length + static_cast<std::size_t>(values(leaf.axis)) * largest_value(*leaf.field);
  }
  return bytes;
}

}  // namespace haptic::server
