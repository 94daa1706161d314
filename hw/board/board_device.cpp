#include "hw/board/board_device.hpp"

#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/board/board_io.hpp"
#include "hw/board/board_reading.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw {
namespace {

constexpr core::Duration kPatience = std::chrono::seconds(3);

board::Expectation expectation(const BoardConfig& config, const core::Kinematics& kinematics,
                               core::Duration longest_lateness) {
  board::Expectation expected;
  expected.dofs = kinematics.dofs();
  expected.max_effort = config.max_effort;
  expected.longest_lateness = longest_lateness;
  expected.serial = config.serial;
  return expected;
}

std::string describe(const board::Identity& identity, const std::string& port) {
  std::ostringstream text;
  text << identity.model << ", firmware " << static_cast<int>(identity.firmware[0]) << '.'
       << static_cast<int>(identity.firmware[1]) << '.' << static_cast<int>(identity.firmware[2])
       << ", at " << port;
  return text.str();
}

}  // namespace

std::unique_ptr<Device> BoardConfig::open(std::shared_ptr<const core::Kinematics> kinematics,
                                          core::Duration longest_lateness) const {
  return std::make_unique<BoardDevice>(*this, kinematics, longest_lateness);
}

std::optional<Travel> BoardConfig::travel() const {
  if (!calibration) return std::nullopt;
  return Travel{calibration->lower, calibration->upper};
}

BoardDevice::BoardDevice(const BoardConfig& config,
                         const std::shared_ptr<const core::Kinematics>& kinematics,
                         core::Duration longest_lateness)
    : layout_(kinematics->layout()), calibration_(config.calibration) {
  info_.kind = "board";
  info_.dofs = kinematics->dofs();
  info_.limits = device_limits(*kinematics, config.max_effort);
  info_.limits.max_silence = config.max_silence;
  io_ = std::make_unique<Io>(config.port, config.baud,
                             expectation(config, *kinematics, longest_lateness));
  const board::Identity identity = io_->greeted(kPatience);
  info_.model = describe(identity, config.port);
  info_.serial = identity.serial;
  info_.limits.sample_period = std::chrono::microseconds(identity.sample_period_us);
  info_.notes = io_->notes();
  info_.measures_force = (identity.capabilities & board::kMeasuresForce) != 0;
  info_.closes_force_loop = (identity.capabilities & board::kForceLoop) != 0;
  info_.takes_positions = (identity.capabilities & board::kPositionCommand) != 0;
  if (calibration_) {
    board::check(*calibration_, *kinematics, info_.serial, info_.measures_force);
    board::apply(*calibration_, info_.limits);
    info_.calibrated = calibration_->date;
  }
  wanted_.tau_a = core::VecA::Zero(config.max_effort.size());
}

BoardDevice::~BoardDevice() {
  close();
}

void BoardDevice::close() noexcept {
  io_->stop();
}

SampleSignal* BoardDevice::sample_signal() noexcept {
  return &io_->samples;
}

board::HostCounters BoardDevice::counters() const {
  return io_->counters();
}

std::vector<LinkCount> BoardDevice::link_counts() const {
  const board::HostCounters n = counters();
  const board::Counters& b = n.board;
  return {{"host", "received", n.frames},
          {"host", "lost", n.lost},
          {"host", "bad_crc", n.bad_crc},
          {"host", "malformed", n.malformed},
          {"host", "not_newer", n.not_newer},
          {"host", "sent", n.sent},
          {"host", "held_back", n.commands_held_back},
          {"board", "accepted", b.accepted},
          {"board", "bad_crc", b.bad_crc},
          {"board", "malformed", b.malformed},
          {"board", "not_newer", b.not_newer},
          {"board", "wrong_nonce", b.wrong_nonce},
          {"board", "without_room", b.states_dropped}};
}

void BoardDevice::read(core::TimePoint, core::DeviceReading& reading) noexcept {
  static_cast<void>(io_->readings.take());
  board::to_reading(io_->readings.value(), wanted_, last_seq_, reading);
  if (calibration_ && reading.fresh) board::apply(*calibration_, reading.sample);
}

void BoardDevice::write(core::TimePoint, const Command& command) noexcept {
  board::to_wish(command, wanted_);
  if (calibration_) board::to_board(*calibration_, layout_, info_.closes_force_loop, wanted_);
  io_->want(wanted_);
}

}  // namespace haptic::hw
