#include "server/state/state_message.hpp"

#include <algorithm>

#include "haptic/schema/fields.hpp"

namespace haptic::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <std::size_t N>
void copy(const Numbers<N>& from, Doubles* to) {
  to->Clear();
  to->Add(from.begin(), from.end());
}

std::uint64_t whole_microseconds(core::Duration age) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(age).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, us));
}

void to_proto(const core::PassivityRecord& record, v1::PassivityState& state) {
  state.set_tank(record.tank);
  state.set_storage(record.storage);
  state.set_scale(record.scale);
  state.set_observed(record.observed);
  state.set_alpha(record.alpha);
}

void to_proto(const core::TrackerRecord& record, v1::TrackerState& state) {
  state.set_seq_used(record.seq);
  state.set_age_us(whole_microseconds(record.age));
  state.set_staleness(static_cast<v1::StalenessLevel>(record.level));
}

void to_proto(const core::Certificate& certificate, v1::CertificateState& state) {
  state.set_status(static_cast<v1::CertificateStatus>(certificate.status));
  state.set_margin(certificate.margin);
  state.set_block(static_cast<std::uint32_t>(certificate.block));
}

/// One per actuated DoF, or none if none acted.
void to_limiters(const StateRecord& record, v1::DeviceState& state) {
  state.clear_actuator_limiters();
  const auto begin = record.actuator_limiters.begin();
  const auto end = begin + record.tau_a.count;
  if (std::any_of(begin, end, [](std::uint32_t bits) { return bits != 0; })) {
    state.mutable_actuator_limiters()->Add(begin, end);
  }
}

void write_record(const StateRecord& record, v1::DeviceState& state) {
  state.set_seq(record.tick);
  state.set_server_time_ns(record.now.time_since_epoch().count());
  copy(record.q, state.mutable_q());
  copy(record.q_a_dot, state.mutable_q_dot());
  copy(record.x_probe, state.mutable_x_probe());
  copy(record.x, state.mutable_x());
  state.set_active_planes(record.active_planes);
  state.clear_passivity();
  if (record.passivity.on) to_proto(record.passivity, *state.mutable_passivity());
  copy(record.q_star, state.mutable_q_star());
  copy(record.tau_a, state.mutable_tau_a());
  copy(record.tau_elastic, state.mutable_tau_elastic());
  state.set_proxy_seq_used(record.proxy_seq);
  state.set_proxy_age_us(whole_microseconds(record.proxy_age));
  state.clear_tracker();
  if (record.tracker.on) to_proto(record.tracker, *state.mutable_tracker());
  state.set_staleness(static_cast<v1::StalenessLevel>(record.staleness));
  state.set_gain(record.gain);
  state.set_transport(static_cast<v1::Transport>(record.carrier));
  state.set_state(static_cast<v1::DeviceStateName>(record.state));
  state.set_faults(record.faults.bits());
  state.set_limiters(record.limiters.bits());
  state.clear_stiffness_in_effect();
  for (const double k : record.stiffness) state.add_stiffness_in_effect(record.gain * k);
  state.set_projection(static_cast<v1::ProjectionStatus>(record.projection));
  state.set_condition(record.condition);
  state.set_lease_epoch(record.lease_epoch);
  state.set_mode(static_cast<v1::ProxyMode>(record.mode));
  state.clear_certificate();
  if (record.certificate.status != core::CertificateStatus::kOff) {
    to_proto(record.certificate, *state.mutable_certificate());
  }
  copy(record.tau_measured, state.mutable_tau_measured());
  copy(record.reading, state.mutable_reading());
  copy(record.temperature_c, state.mutable_temperature_c());
  copy(record.drive, state.mutable_drive());
  to_limiters(record, state);
}

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
  write_record(record, state_);
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
    constexpr std::size_t kTagAndLength = 4;
    bytes +=
        kTagAndLength + static_cast<std::size_t>(values(leaf.axis)) * largest_value(*leaf.field);
  }
  return bytes;
}

}  // namespace haptic::server
