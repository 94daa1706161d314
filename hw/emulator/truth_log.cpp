#include "hw/emulator/truth_log.hpp"

#include <array>
#include <cstdio>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr std::uint64_t kEveryUs = 10000;

}  // namespace

TruthLog::TruthLog(const std::string& file) : csv_(file) {
  csv_ << "time_s,l_x_m,q_B_rad,force_n\n" << std::flush;
  if (!csv_) throw core::DeviceError("truth '" + file + "': must be a file that can be written");
  thread_ = std::jthread([this](const std::stop_token& stop) { drain(stop); });
}

void TruthLog::write(const EmulatedBoard& board) {
  if (board.now_us() < next_us_) return;
  next_us_ = board.now_us() + kEveryUs;
  const Rig& rig = board.rig();
  std::array<char, 128> row{};
  std::snprintf(row.data(), row.size(), "%.3f,%.7f,%.6f,%.4f\n",
                static_cast<double>(board.now_us()) * 1e-6, rig.actuator().x(), rig.finger().q()[1],
                rig.actuator().force());
  {
    const std::lock_guard lock(mutex_);
    pending_ += row.data();
  }
  changed_.notify_one();
}

void TruthLog::drain(const std::stop_token& stop) {
  std::string rows;
  std::unique_lock lock(mutex_);
  while (true) {
    if (!changed_.wait(lock, stop, [this] { return !pending_.empty(); })) return;
    rows.clear();
    rows.swap(pending_);
    lock.unlock();
    csv_ << rows << std::flush;
    lock.lock();
  }
}

}  // namespace haptic::hw::emulator
