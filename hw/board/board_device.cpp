#include "hw/board/board_device.hpp"

#include "hw/board/board_io.hpp"

namespace haptic::hw {

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
    : side_(config, kinematics, longest_lateness),
      io_(std::make_unique<Io>(config.port, config.baud, side_.expectation())) {
  constexpr core::Duration kPatience = std::chrono::seconds(3);
  side_.identify(io_->greeted(kPatience));
  side_.info().model += ", at " + config.port;
  for (const std::string& note : io_->notes()) side_.info().notes.push_back(note);
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
  side_.read(io_->readings.value(), reading);
}

void BoardDevice::write(core::TimePoint, const Command& command) noexcept {
  io_->want(side_.write(command));
}

}  // namespace haptic::hw
