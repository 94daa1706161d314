#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <mutex>
#include <sstream>
#include <thread>

#include "calibration/guide.hpp"
#include "commands.hpp"
#include "message_json.hpp"
#include "say.hpp"

namespace haptic::ctl {
namespace {

/// A device behind hapticd. It is a controller that publishes "free" and keeps the device armed at
/// zero force, so that a device that holds itself when it is off gives way to the hand.
class ServedSensors final : public Sensors {
 public:
  ServedSensors(client::Connection& server, const std::string& device)
      : server_(server), device_(device) {
    session_ = open(false);
    publisher_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        session_->publish(client::Proxy::free());
        std::this_thread::sleep_for(std::chrono::milliseconds(16));
      }
    });
  }
  ~ServedSensors() override {
    stop_publishing();
    session_->close();  // take() is not called any more
  }

  /// Without a controller the device is disarmed.
  void switch_off() override {
    stop_publishing();
    session_->close();
    session_ = open(true);
  }

  void begin() override {
    const std::lock_guard lock(mutex_);
    seen_ = {};
    forces_ = 0;
  }
  Statistics end() override {
    if (!session_->connected()) {
      throw client::ClientError(client::ErrorReason::kClosed, "the session ended");
    }
    const std::lock_guard lock(mutex_);
    refuse_fault();
    Statistics answer = seen_;
    for (double& sum : answer.mean) sum /= static_cast<double>(answer.samples);
    for (double& sum : answer.force) sum /= static_cast<double>(forces_);
    return answer;
  }
  void pause(double seconds) override {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  }

 private:
  std::unique_ptr<client::Session> open(bool observer) {
    client::SessionOptions wanted;
    wanted.device = device_;
    wanted.observer = observer;
    wanted.client_name = "hapticctl calibrate";
    wanted.on_state = [this](const client::DeviceState& state) { take(state); };
    return server_.open(wanted);
  }
  /// Under the mutex. A device in FAULT is disarmed and cannot be moved to the next place.
  void refuse_fault() const {
    if (faults_ == 0) return;
    throw DeviceInFault(
        "'" + device_ + "' is in FAULT, " + joined(client::fault_names(faults_)) +
        ": nothing was written. Clear it with hapticctl clear-fault and begin again; "
        "if a reading left the scene's range by more than 5 % of its span, choose "
        "places and travel within it, or repair the sensor first");
  }
  void stop_publishing() {
    publisher_.request_stop();
    if (publisher_.joinable()) publisher_.join();
  }
  void take(const client::DeviceState& state) {
    const std::vector<double>& reading = state.reading.empty() ? state.q : state.reading;
    const std::lock_guard lock(mutex_);
    faults_ = state.faults;
    if (seen_.samples++ == 0) {
      seen_.mean.assign(reading.size(), 0.0);
      seen_.lowest = seen_.highest = reading;
    }
    for (std::size_t i = 0; i < std::min(reading.size(), seen_.mean.size()); ++i) {
      seen_.mean[i] += reading[i];
      seen_.lowest[i] = std::min(seen_.lowest[i], reading[i]);
      seen_.highest[i] = std::max(seen_.highest[i], reading[i]);
    }
    if (state.tau_measured.empty()) return;
    ++forces_;
    seen_.force.resize(state.tau_measured.size());
    for (std::size_t i = 0; i < seen_.force.size(); ++i) seen_.force[i] += state.tau_measured[i];
  }

  client::Connection& server_;
  std::string device_;
  std::mutex mutex_;
  Statistics seen_{};  ///< sums in mean and force
  std::uint64_t forces_{0};
  std::uint32_t faults_{0};
  std::unique_ptr<client::Session> session_;
  std::jthread publisher_;
};

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::ostringstream text;
  text << std::put_time(std::localtime(&now), "%F");
  return text.str();
}

/// The one device that the options name. Throws kInvalidArgument if it cannot be calibrated.
client::DeviceInfo device_of(client::Connection& server, const std::string& name) {
  const auto refuse = [](const std::string& why) {
    throw client::ClientError(client::ErrorReason::kInvalidArgument, why);
  };
  const auto devices = meant(server, name);
  if (devices.size() != 1) refuse("several devices are served: say which, --device NAME");
  const client::DeviceInfo& device = devices.front();
  if (device.serial.empty()) {
    refuse("'" + device.name + "' is a " + device.kind +
           " device without a serial number: only a board can be calibrated");
  }
  if (!device.calibrated.empty()) {
    refuse("'" + device.name + "' is served with its calibration of " + device.calibrated +
           ": start hapticd without board.calibration_file to make a new one");
  }
  // They stand in questions, and the serial number is the file's name.
  std::vector<std::string> words{device.serial};
  for (const auto& dof : device.dofs) words.insert(words.end(), {dof.name, dof.unit});
  for (const std::string& word : words) {
    const bool odd = word.find('/') != std::string::npos || wire::printable(word) != word;
    if (odd) refuse("the server's name '" + word + "' is none: must be readable, without '/'");
  }
  return device;
}

/// Asks before it writes the file; false: nothing was written.
bool save(Guide& guide, std::ostream& out, const std::string& text, const std::string& file) {
  out << '\n' << text << '\n';
  if (!guide.agrees("Write this to " + file + "?")) {
    complain("nothing was written");
    return false;
  }
  std::ofstream stream(file);
  stream << text;
  stream.close();
  if (!stream) {
    complain("%s cannot be written", file);
    return false;
  }
  out << "written; a scene uses it by board { calibration_file: \"" << file << "\" }\n";
  return true;
}

}  // namespace

int calibrate(const Options& options) {
  client::Connection server = connect(options);
  const client::DeviceInfo device = device_of(server, options.device);
  ServedSensors sensors(server, device.name);
  std::ostream& out = options.json ? std::cerr : std::cout;  // the questions
  Guide guide(sensors, std::cin, out);
  try {
    v1::Calibration result = guide.run(device.dofs);
    result.set_device_serial(device.serial);
    result.set_date(today());
    const std::string file = options.output.empty() ? device.serial + ".textproto" : options.output;
    if (!save(guide, out, to_textproto(result), file)) return 1;
    if (options.json) {
      nlohmann::json all = to_json(result);
      all["file"] = file;
      say("%s\n", dump(all));
    }
    return 0;
  } catch (const CalibrationAborted& aborted) {
    complain("calibration ended: %s; nothing was written", std::string(aborted.what()));
    return 1;
  }
}

}  // namespace haptic::ctl
