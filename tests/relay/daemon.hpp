#pragma once
/// The shipped hapticd as a process, with a finger at rest that a client presses. Its ports are
/// free on the relay's address too, and it records every tick.

#include <memory>
#include <string>
#include <vector>

#include "tests/support/temporary_file.hpp"
#include "tests/system/process.hpp"

namespace haptic::test {

class Daemon {
 public:
  static constexpr double kTarget = 0.5236;      ///< rad, the rest position of both joints
  static constexpr double kForceLimit = 25.0;    ///< N
  static constexpr double kSlew = 1000.0;        ///< N/s
  static constexpr double kTank = 0.05;          ///< J, at every Engage
  static constexpr double kDeviceDamping = 2.0;  ///< N s/m, the simulated actuator's own

  static constexpr char kToken[] = "token-of-a-controller";  ///< on the web

  /// Returns when it listens, or 10 s later. `arguments`: more of them.
  explicit Daemon(std::vector<std::string> arguments = {});
  /// The same with a shipped scene, by its name.
  explicit Daemon(const std::string& shipped_scene);

  [[nodiscard]] std::uint16_t tcp_port() const { return tcp_port_; }
  [[nodiscard]] std::uint16_t udp_port() const { return udp_port_; }
  /// Port of WebSockets; not of a shipped scene.
  [[nodiscard]] std::uint16_t web_port() const { return web_port_; }
  [[nodiscard]] std::string web_behind_relay() const {
    return "127.0.0.2:" + std::to_string(web_port_);
  }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(tcp_port_); }
  [[nodiscard]] std::string behind_relay() const {
    return "127.0.0.2:" + std::to_string(tcp_port_);
  }
  /// Sends SIGTERM and returns the exit code, also if it has ended before. Completes the record.
  int stop();
  [[nodiscard]] const std::filesystem::path& record() const { return record_; }

 private:
  void start(std::vector<std::string> scene);

  ScratchFolder folder_{};
  std::filesystem::path record_{};
  std::uint16_t tcp_port_{0}, udp_port_{0}, web_port_{0};
  std::unique_ptr<Process> process_{};
};

}  // namespace haptic::test
