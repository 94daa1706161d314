#include "hw/emulator/emulated_board.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic::hw::emulator {
namespace {

constexpr double kSecond = 1e6;  // us
constexpr std::uint64_t kStepUs = Rig::kStepUs;
/// With one quantum rms of noise 100 equal readings in a row do not happen.
constexpr std::uint16_t kStuckAfter = 100;

/// The position servo: N per m, and the friction fed forward beyond 0.1 mm. The motor's back-EMF
/// (3125 N s/m) damps it well above critical.
constexpr double kServo = 1e5, kServoFriction = 25.0, kServoBand = 1e-4;

/// At full drive a sound L16 is beyond this in 10 ms; noise of the potentiometer is not.
constexpr float kStandsStill = 2e-4F;  // m
constexpr float kNearEnd = 1e-3F;      // m
constexpr int kStallMs = 200;

std::uint8_t capabilities(BoardControl control) {
  switch (control) {
    case BoardControl::kForceLoop:
      return HB_FORCE_LOOP | HB_MEASURES_FORCE;
    case BoardControl::kDrive:
      return HB_MEASURES_FORCE;
    case BoardControl::kPosition:
      break;
  }
  return HB_MEASURES_FORCE | HB_POSITION_COMMAND;
}

hb_dof dictionary_entry(const core::DofSpec& dof, const ActuatorParameters& actuator) {
  hb_dof entry{};
  entry.name = dof.name.c_str();
  entry.radian = dof.unit == core::Unit::kRadian;
  entry.actuated = dof.actuated;
  entry.lower = static_cast<float>(dof.lower);
  entry.upper = static_cast<float>(dof.upper);
  if (dof.actuated) {
    entry.max_effort = static_cast<float>(actuator.max_force);
    entry.max_rate = static_cast<float>(actuator.no_load_speed);
  }
  entry.stuck_after = kStuckAfter;
  return entry;
}

}  // namespace

EmulatedBoard::EmulatedBoard(const EmulatorConfig& config, HandIntent intent,
                             const std::shared_ptr<const core::Kinematics>& kinematics)
    : config_(config),
      rig_(config.actuator, config.sensors, std::move(intent), kinematics, config.seed),
      force_loop_(config.force_loop),
      random_(config.seed ^ 0x9E3779B97F4A7C15U) {
  for (std::size_t i = 0; i < 2; ++i) {
    // The names live as long as the kinematics, which the rig holds.
    dofs_[i] = dictionary_entry(kinematics->dofs().at(i), config.actuator);
  }
  board_config_ = {config_.serial.c_str(),
                   config_.model.c_str(),
                   {1, 0, 0},
                   capabilities(config_.control),
                   config_.watchdog_us,
                   static_cast<std::uint32_t>(kSampleUs),
                   dofs_,
                   2};
  hb_init(&board_, &board_config_, &EmulatedBoard::send, this);
}

bool EmulatedBoard::is_active(FaultKind kind) const noexcept {
  const double t = static_cast<double>(now_us_) / kSecond;
  return std::any_of(config_.faults.begin(), config_.faults.end(),
                     [&](const FaultSpec& f) { return f.kind == kind && f.active(t); });
}

std::uint64_t EmulatedBoard::board_us() const noexcept {
  const auto since_boot = static_cast<double>(now_us_ - booted_us_);
  return static_cast<std::uint64_t>(since_boot * (1.0 + 1e-6 * config_.clock_ppm));
}

// The link.

bool EmulatedBoard::send(void* context, const std::uint8_t* bytes, std::size_t length) {
  auto& self = *static_cast<EmulatedBoard*>(context);
  if (self.outgoing_.size() + self.released_.size() + length > self.room_) return false;
  self.outgoing_.insert(self.outgoing_.end(), bytes, bytes + length);
  return true;
}

/// Loses and damages bytes as a noisy wire does.
void EmulatedBoard::pass(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
  for (std::uint8_t byte : bytes) {
    if (config_.drop > 0.0 && uniform(random_) < config_.drop) continue;
    if (config_.corrupt > 0.0 && uniform(random_) < config_.corrupt) {
      byte ^= static_cast<std::uint8_t>(1U << (random_() % 8));
    }
    out.push_back(byte);
  }
}

void EmulatedBoard::receive(std::span<const std::uint8_t> bytes) {
  if (!plugged()) return;
  pass(bytes, incoming_);
  if (config_.link_period_us == 0) deliver();
}

void EmulatedBoard::deliver() {
  if (powered_ && !is_active(FaultKind::kHang)) {
    for (const std::uint8_t byte : incoming_) hb_receive(&board_, byte, board_us());
  }
  incoming_.clear();
  pass(outgoing_, released_);
  outgoing_.clear();
}

std::vector<std::uint8_t> EmulatedBoard::take_output() {
  if (config_.link_period_us == 0) deliver();
  if (!plugged()) released_.clear();
  return std::exchange(released_, {});
}

// The board.

bool EmulatedBoard::has_supply() {
  const bool powered = !is_active(FaultKind::kBrownOut);
  if (powered && !powered_) {
    booted_us_ = now_us_;
    hb_init(&board_, &board_config_, &EmulatedBoard::send, this);
    force_loop_.reset();
    outgoing_.clear();
  }
  powered_ = powered;
  return powered;
}

void EmulatedBoard::disturb(Readings& readings) {
  for (const FaultSpec& fault : config_.faults) {
    if (fault.kind == FaultKind::kDrift && fault.active(static_cast<double>(now_us_) / kSecond)) {
      drift_ += fault.amount * static_cast<double>(kSampleUs) / kSecond;
    }
  }
  const double l_x = static_cast<double>(readings.q[0]) + drift_;
  readings.q[0] = static_cast<float>(config_.l_x_scale * (l_x + config_.l_x_offset));
  readings.force[0] += static_cast<float>(config_.force_offset);
  const bool stuck = is_active(FaultKind::kStuck);
  if (stuck && !was_stuck_) stuck_at_ = readings.q[0];
  if (stuck) readings.q[0] = stuck_at_;
  was_stuck_ = stuck;
}

/// How a board detects a dead motor: the loop is at its limit and the rod does not move, although
/// it is not at an end of its stroke.
bool EmulatedBoard::stalled(const Readings& readings) noexcept {
  const bool moved = std::abs(readings.q[0] - stood_at_) > kStandsStill;
  const bool at_an_end =
      readings.q[0] < dofs_[0].lower + kNearEnd || readings.q[0] > dofs_[0].upper - kNearEnd;
  if (moved || at_an_end || !force_loop_.saturated()) {
    stood_at_ = readings.q[0];
    pushing_in_vain_ = 0;
    return false;
  }
  return ++pushing_in_vain_ > kStallMs;
}

double EmulatedBoard::drive_force(const Readings& readings) noexcept {
  switch (config_.control) {
    case BoardControl::kForceLoop:
      return force_loop_.step(reference_, static_cast<double>(readings.force[0]),
                              static_cast<double>(kSampleUs) / kSecond);
    case BoardControl::kDrive:
      return reference_;
    case BoardControl::kPosition:
      break;
  }
  const double e = reference_ - static_cast<double>(readings.q[0]);
  return kServo * e + kServoFriction * std::clamp(e / kServoBand, -1.0, 1.0);
}

/// One millisecond of the firmware.
void EmulatedBoard::control() {
  const bool drove = std::exchange(drives_, false);
  reference_ = 0.0;
  if (has_supply() && !is_active(FaultKind::kHang)) {
    Readings readings = rig_.sense();
    disturb(readings);
    const bool over = std::abs(static_cast<double>(readings.force[0])) > config_.force_over_limit;
    const auto faults = static_cast<std::uint8_t>((over ? HB_FORCE_OVER_LIMIT : 0) |
                                                  (drove && stalled(readings) ? HB_ACTUATOR : 0));
    hb_sample(&board_, board_us(), readings.q, readings.force, faults);
    float reference = 0.0F;
    hb_kind kind = HB_FORCE;
    drives_ = hb_reference(&board_, board_us(), &reference, &kind);
    reference_ = static_cast<double>(reference);
    if (!drives_) force_loop_.reset();
    rig_.actuator().drive(drives_ ? drive_force(readings) : 0.0, drives_);
  } else {
    rig_.actuator().drive(0.0, false);
  }
  rig_.actuator().stall(is_active(FaultKind::kStall));
}

void EmulatedBoard::advance(std::uint64_t now_us) {
  while (now_us_ + kStepUs <= now_us) {
    now_us_ += kStepUs;
    rig_.step();
    if (now_us_ % kSampleUs == 0) control();
    if (config_.link_period_us != 0 && now_us_ % config_.link_period_us == 0) deliver();
  }
}

}  // namespace haptic::hw::emulator
