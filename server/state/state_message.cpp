#include "server/state/state_message.hpp"

#include <algorithm>

#include "haptic/schema/fields.hpp"

namespace haptic::server {
namespace {

void write_coupling(const std::vector<core::CouplingBlock>& blocks, v1::DeviceState& state) {
  state.clear_coupling_metric();
  for (const core::CouplingBlock& block : blocks) {
    v1::CouplingBlock& message = *state.add_coupling_metric();
    message.set_coordinates(static_cast<std::uint32_t>(block.coordinates));
    message.mutable_lower()->Add(block.lower.begin(), block.lower.end());
  }
}

/// A coupling metric in which no block is empty.
std::vector<core::CouplingBlock> full_coupling(const core::PipelineConfig& config) {
  const core::ProjectionModel model(*config.kinematics, config.projection);
  std::vector<core::CouplingBlock> blocks = core::coupling_blocks(model, {}, {}, 1.0);
  for (core::CouplingBlock& block : blocks) {
    const auto n = static_cast<std::size_t>(block.coordinates);
    block.lower.assign(n * (n + 1) / 2, 1.0);
  }
  return blocks;
}

}  // namespace

StateMessage::StateMessage(const core::PipelineConfig& config,
                           std::optional<double> coupling_softness) {
  if (!coupling_softness) return;
  coupling_.emplace(Coupling{{*config.kinematics, config.projection}, *coupling_softness});
}

const v1::DeviceState& StateMessage::write(const StateRecord& record) {
  haptic::server::write(record, state_);
  if (coupling_) {
    const auto vector = [](const Values& from) {
      return core::VecQ(Eigen::Map<const core::VecQ>(from.begin(), from.count));
    };
    write_coupling(core::coupling_blocks(coupling_->model, vector(record.q),
                                         vector(record.stiffness), coupling_->softness),
                   state_);
  }
  return state_;
}

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

std::size_t largest_state(const core::PipelineConfig& config, bool coupled) {
  const core::DofLayout& layout = config.kinematics->layout();
  const auto values = [&](v1::Axis axis) {
    if (axis == v1::AXIS_DOF) return layout.n_q();
    if (axis == v1::AXIS_ACTUATED) return layout.n_a();
    return axis == v1::AXIS_COORDINATE ? config.kinematics->space().n_x() : 1;
  };
  const auto absent = [&](int field) {
    return (field == v1::DeviceState::kPassivityFieldNumber && !config.passivity.enabled()) ||
           (field == v1::DeviceState::kTrackerFieldNumber && !config.tracker) ||
           (field == v1::DeviceState::kCertificateFieldNumber && !config.passivity_certificate) ||
           (field == v1::DeviceState::kTemperatureCFieldNumber && config.ratings.empty());
  };
  v1::DeviceState state;
  if (coupled) write_coupling(full_coupling(config), state);
  std::size_t bytes = state.ByteSizeLong();
  for (const schema::Leaf& leaf : schema::leaves(*v1::DeviceState::descriptor())) {
    if (leaf.field->message_type() != nullptr) continue;  // the coupling metric
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
