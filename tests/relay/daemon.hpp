#pragma once
/// hapticd as it ships, a process of its own, with a finger at rest that a client presses: TCP and UDP on
/// ports that are free on the relay's address too, every tick recorded.

#include <filesystem>
#include <memory>
#include <string>

#include "tests/system/process.hpp"

namespace haptic::test {

class Daemon {
 public:
  static constexpr double kTarget = 0.5236;      ///< rad, where both joints come to rest
  static constexpr double kForceLimit = 25.0;    ///< N
  static constexpr double kSlew = 1000.0;        ///< N/s
  static constexpr double kTank = 0.05;          ///< J, at every Engage
  static constexpr double kDeviceDamping = 2.0;  ///< N s/m, the simulated actuator's own

  /// `more`: other fields of the scene. Returns when it listens, or did not within 10 s.
  explicit Daemon(const std::string& more = {});
  ~Daemon();

  [[nodiscard]] std::uint16_t tcp_port() const { return tcp_port_; }
  [[nodiscard]] std::uint16_t udp_port() const { return udp_port_; }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(tcp_port_); }
  [[nodiscard]] std::string behind_relay() const {
    return "127.0.0.2:" + std::to_string(tcp_port_);
  }
  /// SIGTERM; its exit code, again where it has ended before. The record is complete then.
  int stop();
  void signal(int number) const { process_->signal(number); }
  [[nodiscard]] const std::filesystem::path& record() const { return record_; }

 private:
  std::filesystem::path folder_, record_;
  std::uint16_t tcp_port_{0}, udp_port_{0};
  std::unique_ptr<Process> process_{};
};

}  // namespace haptic::test
