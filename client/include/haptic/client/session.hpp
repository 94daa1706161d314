#pragma once
/// A session on a device: publish proxies, receive states, ask for force.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/error.hpp"
#include "haptic/client/types.hpp"

namespace haptic::client {

enum class Reconnect : std::uint8_t {
  kNever,       ///< the session ends with its stream
  kWithBackoff  ///< opened anew after 0.1, 0.2, 0.4 ... 2 s; force never returns by itself
};

struct SessionOptions {
  std::string device{};  ///< empty: the only one
  bool observer{false};
  std::string client_name{"haptic client"};
  double nominal_rate_hz{60.0};  ///< of publish(); controller only
  double state_rate_hz{0.0};     ///< 0: every tick
  std::optional<std::chrono::nanoseconds> fresh_end{}, hold_end{}, fade_end{};  ///< tighten only
  Reconnect reconnect{Reconnect::kNever};
  /// After force was lost (stale proxy, reconnect) ask for it again as soon as the server would
  /// agree.
  /// Never after a fault: clearing one must not start a motor. Ask again with engage_when_ready().
  bool re_engage{false};
  std::chrono::milliseconds timeout{5000};  ///< of calls that wait for an answer
  std::function<void(const DeviceState&)> on_state{};
  std::function<void(const Event&)> on_event{};
  /// The session ended (or lost its stream and will try again: `will_retry`).
  std::function<void(const ClientError&, bool will_retry)> on_disconnect{};
};

struct Settings {
  std::vector<double> stiffness{}, damping{}, force_limit{}, slew_limit{};  ///< empty: unchanged
  Renderer renderer{Renderer::kUnchanged};
  std::optional<bool> direction_guard{};
};

struct AppliedSettings {
  Settings applied{};
  struct Clamp {
    std::string field{};
    double asked{0.0}, applied{0.0};
    std::string why{};
  };
  std::vector<Clamp> clamped{};
};

class Session {
 public:
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Never blocks, never throws. The newest sample wins: one that could not be sent yet is replaced
  /// and counted. Only this call creates sequence numbers.
  void publish(Proxy proxy) noexcept;

  /// The newest state; seq 0 before the first, also after a reconnect.
  [[nodiscard]] DeviceState state() const;
  /// Waits for a state newer than the last one this call returned. Throws kTimeout, kClosed.
  [[nodiscard]] DeviceState wait_for_state();

  /// Asks for force, once. Throws kNotReady naming what is missing.
  void engage();
  /// Asks for force as soon as the server would agree, in the background. Idempotent.
  /// Ends with a refusal that time cannot cure, and with a fault.
  void engage_when_ready();
  /// Gives force up; it fades out. Also ends engage_when_ready().
  void release();
  AppliedSettings update(const Settings& settings);

  [[nodiscard]] bool connected() const;
  [[nodiscard]] Transport transport() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const;

  /// Ends the session; force fades out at the server. The destructor does the same.
  void close();

 private:
  friend class Connection;
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::client
