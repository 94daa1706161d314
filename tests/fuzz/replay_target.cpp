#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "hw/replay/replay.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace {

std::shared_ptr<const core::Kinematics> finger() {
  static const std::shared_ptr<const core::Kinematics> kFinger = core::make_finger_exoskeleton({});
  return kFinger;
}
std::shared_ptr<const core::Kinematics> palm() {
  static const std::shared_ptr<const core::Kinematics> kPalm = [] {
    core::SerialChainParameters chain{.palm = core::TrackedPalm{}};
    chain.joints.push_back({"a"});
    chain.outputs = {{"tip", "", core::OutputKind::kFrame, {{0.1, 0, 0}, {}}}};
    return core::make_serial_chain(chain);
  }();
  return kPalm;
}

/// A file in memory with a name.
class MemoryFile {
 public:
  explicit MemoryFile(FuzzInput text) : number_(::memfd_create("replay", MFD_CLOEXEC)) {
    if (::write(number_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      throw std::runtime_error("no file in memory");
    }
  }
  ~MemoryFile() { ::close(number_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(number_); }

 private:
  int number_;
};

/// Plays it: at 200 moments over its length, then in the steps of a loop beyond its end.
std::string play(hw::Replay& device, const core::Kinematics& kinematics) {
  const int n_q = kinematics.layout().n_q();
  const core::Duration length = device.facts().length;
  if (length < core::Duration(0)) return "a recording of negative length";
  const core::DeviceLimits& limits = device.info().limits;
  core::DeviceReading reading;
  core::TimePoint now{std::chrono::hours(1)};
  for (int i = 0; i < 400; ++i) {
    device.read(now, reading);
    const core::VecQ& q = reading.sample.q;
    if (reading.fresh && q.size() != n_q) return "a sample of a wrong size";
    for (Eigen::Index k = 0; reading.fresh && k < q.size(); ++k) {
      if (!std::isfinite(q[k])) return "a sample that is no number";
      const double slack = 1e-9 + 1e-9 * std::abs(q[k]);
      if (q[k] < limits.q_lower[k] - slack || q[k] > limits.q_upper[k] + slack) {
        return "a sample out of the device's range";
      }
    }
    now += i < 200 ? length / 200 : core::Duration(std::chrono::milliseconds(1));
  }
  return {};
}

std::string open_and_play(FuzzInput input) {
  FuzzReader head(input);
  const std::uint8_t options = head.byte();
  const auto kinematics = (options & 1U) != 0 ? palm() : finger();
  const MemoryFile file(input.subspan(std::min<std::size_t>(1, input.size())));
  hw::ReplayConfig config;
  config.file = file.path();
  config.repeat = (options & 2U) != 0;
  config.max_effort = core::VecA::Constant(1, 1.0);
  try {
    hw::Replay device(config, kinematics);
    return play(device, *kinematics);
  } catch (const core::DeviceError& error) {
    return *error.what() == '\0' ? "an error without a word" : "";
  } catch (const std::exception& error) {
    return std::string("another exception than DeviceError: ") + error.what();
  }
}

std::vector<FuzzBytes> replay_seeds() {
  const std::array<const char*, 5> texts{
      "\x02time_s,l_x,q_B\n0,0.01,0.1\n0.02,0.012,0.12\n0.04,0.014,0.1\n",
      "\x02time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0.1,0.2\n0.01,0.11,0.25\n0.2,0.3,0.4\n0.21,0.3,0."
      "5\n",
      "\x03time_s,palm.x,palm.y,palm.z,palm.qx,palm.qy,palm.qz,palm.qw,a\n"
      "0,0.1,0.2,0.3,0,0,0,1,0.5\n0.02,0.1,0.2,0.3,0,0,0.1,0.99,0.5\n",
      "\x03time_s,palm.x,palm.y,palm.z,palm.rx,palm.ry,palm.rz,a\n"
      "0,0,0,0,3.1,0,0,0\n0.02,0,0,0,-3.1,0,0,0\n",
      "\x02\xEF\xBB\xBFnote,time_s, q_B,l_x\r\nx,-8e9,+1e-1,.01\r\n,8.9e9,0.1,0.01\r\n"};
  std::vector<FuzzBytes> seeds;
  for (const std::string text : texts) seeds.emplace_back(text.begin(), text.end());
  return seeds;
}

}  // namespace

const FuzzTarget& replay_target() {
  static const FuzzTarget kTarget{"replay", open_and_play, replay_seeds, 2048};
  return kTarget;
}

}  // namespace haptic::test
