#include "server/owner/state_message.hpp"

#include <algorithm>

#include "haptic/schema/fields.hpp"

namespace haptic::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <typename Vector>
void copy(const Vector& from, Doubles* to) {
  to->Clear();
  to->Add(from.data(), from.data() + from.size());
}

void to_passivity(const core::PassivityRecord& record, v1::PassivityState& state) {
  state.set_tank(record.tank);
  state.set_storage(record.storage);
  state.set_scale(record.scale);
  state.set_observed(record.observed);
  state.set_alpha(record.alpha);
}

/// What only some devices have; a state of the others carries none of it.
void to_actuators(const core::TickRecord& record, v1::DeviceState& state) {
  copy(record.input.device.sample.tau_measured, state.mutable_tau_measured());
  core::VecQ reading = record.input.device.sample.q;
  if (record.sensed.tracker.on && reading.size() == record.sensed.q.size()) {
    // What the device says of a tracked palm is not looked at.
    constexpr auto kDofs = static_cast<Eigen::Index>(core::kPalmDofs);
    reading.segment<kDofs>(record.sensed.tracker.first_dof) =
        record.sensed.q.segment<kDofs>(record.sensed.tracker.first_dof);
  }
  const bool refused = reading.size() == record.sensed.q.size() && reading != record.sensed.q;
  copy(refused ? reading : core::VecQ{}, state.mutable_reading());
  copy(record.effort.temperature_c, state.mutable_temperature_c());
  copy(record.effort.drive.size() > 0 ? record.effort.drive : record.effort.position,
       state.mutable_drive());
  state.clear_actuator_limiters();
  const auto n_a = static_cast<std::size_t>(record.effort.tau_a.size());
  const auto begin = record.effort.actuator_limiters.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(n_a);
  if (std::none_of(begin, end, [](core::LimiterSet set) { return set.any(); })) return;
  std::for_each(begin, end, [&](core::LimiterSet set) { state.add_actuator_limiters(set.bits()); });
}

std::uint64_t whole_microseconds(core::Duration age) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(age).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, us));
}

void to_tracker(const core::TrackerRecord& record, v1::TrackerState& state) {
  state.set_seq_used(record.seq);
  state.set_age_us(whole_microseconds(record.age));
  state.set_staleness(static_cast<v1::StalenessLevel>(record.level));
}

void write_record(const core::TickRecord& record, DeviceSessions::Stamp stamp,
                  v1::DeviceState& state) {
  state.set_seq(record.beat.tick);
  state.set_server_time_ns(record.input.now.time_since_epoch().count());
  copy(record.sensed.q, state.mutable_q());
  copy(record.sensed.q_a_dot, state.mutable_q_dot());
  copy(record.anchor.x_probe, state.mutable_x_probe());
  copy(record.anchor.x, state.mutable_x());
  state.set_active_planes(record.anchor.active_planes);
  if (record.effort.passivity.on) {
    to_passivity(record.effort.passivity, *state.mutable_passivity());
  } else {
    state.clear_passivity();
  }
  copy(record.effort.q_star, state.mutable_q_star());
  copy(record.effort.tau_a, state.mutable_tau_a());
  copy(record.effort.tau_elastic, state.mutable_tau_elastic());
  state.set_proxy_seq_used(record.proxy.seq);
  state.set_proxy_age_us(whole_microseconds(record.proxy.age));
  if (record.sensed.tracker.on) {
    to_tracker(record.sensed.tracker, *state.mutable_tracker());
  } else {
    state.clear_tracker();
  }
  state.set_staleness(static_cast<v1::StalenessLevel>(record.proxy.level));
  state.set_gain(record.life.gain);
  state.set_transport(static_cast<v1::Transport>(stamp.carrier));
  state.set_state(static_cast<v1::DeviceStateName>(record.life.state));
  state.set_faults(record.faults().bits());
  state.set_limiters(record.limiters().bits());
  Doubles* stiffness = state.mutable_stiffness_in_effect();
  stiffness->Clear();
  for (const double k : record.input.settings.stiffness) stiffness->Add(record.life.gain * k);
  state.set_projection(static_cast<v1::ProjectionStatus>(record.anchor.projection));
  state.set_condition(record.anchor.condition);
  state.set_lease_epoch(stamp.lease_epoch);
  state.set_mode(static_cast<v1::ProxyMode>(record.proxy.mode));
  if (record.anchor.certificate.status != core::CertificateStatus::kOff) {
    v1::CertificateState& certificate = *state.mutable_certificate();
    certificate.set_status(static_cast<v1::CertificateStatus>(record.anchor.certificate.status));
    certificate.set_margin(record.anchor.certificate.margin);
    certificate.set_block(static_cast<std::uint32_t>(record.anchor.certificate.block));
  } else {
    state.clear_certificate();
  }
  to_actuators(record, state);
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

const v1::DeviceState& StateMessage::write(const core::TickRecord& record,
                                           DeviceSessions::Stamp stamp) {
  write_record(record, stamp, state_);
  if (coupling_) {
    write_coupling(core::coupling_blocks(coupling_->model, record.sensed.q,
                                         record.input.settings.stiffness, coupling_->softness),
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
