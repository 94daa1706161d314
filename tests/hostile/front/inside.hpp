#pragma once
/// An attacker inside the front. The program is the product's own front, main.cpp and all, with one
/// thread more: it begins when the front serves, confined as the front is then, and does what it
/// reads from a pipe. See ../README.md.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/front/session/owner_link.hpp"

namespace haptic::hostile {

using Clock = std::chrono::steady_clock;

/// Descriptors of the attacker's own have this number or a higher one.
inline constexpr int kOwn = 700;
/// The socket to the owner.
inline constexpr int kLink = 3;

/// Listens to all that the owner tells a front.
struct Spy final : server::FrontPort {
  void on_event(std::size_t device, const server::DeviceEvent& event) override {
    if (device == 0 && event.lease_epoch != 0) epoch = event.lease_epoch;
  }
  void on_answer(const server::Answer& answer) override {
    if (answer.id == kSession) session = answer.session_id;
    if (answer.id == kLease) epoch = answer.lease.epoch;
    if (answer.id >= kForged) ++(answer.refusal ? refused : granted);
    answered = answer.id;
  }
  void on_judged(const server::Judged& judged) override {
    if (judged.ticket == kForged && judged.verdict.used()) ++used;
  }

  /// Ids of the attacker's own requests; the front's own are small.
  static constexpr std::uint64_t kSession = std::uint64_t{1} << 40U, kLease = kSession + 1;
  /// The ticket of samples, and the first id of requests, that are watched.
  static constexpr std::uint64_t kForged = std::uint64_t{1} << 46U;
  std::atomic<std::uint64_t> refused{0}, granted{0}, used{0};  ///< of those
  std::atomic<std::uint32_t> epoch{0};  ///< of the newest lease of the first device
  std::atomic<std::uint64_t> answered{0};
  server::SessionId session{};
};

/// Given to every mode.
struct Inside {
  server::OwnerLink& owner;
  Spy& spy;
  std::vector<int> given{};          ///< descriptors that the front had before it served
  std::vector<std::string> words{};  ///< of the command, after the mode and its seconds
  Clock::time_point until{};

  [[nodiscard]] bool goes_on() const { return Clock::now() < until; }
  /// Also a number: 0 if there is none.
  [[nodiscard]] long number(std::size_t word) const;
};

/// Writes a line to whoever gave the command.
void answer(const std::string& line);
/// Every thread but this one and the one that beats stops for good.
void freeze_the_front();
/// The owner's pages as this process has them mapped.
[[nodiscard]] const server::OwnersPages* owners_pages(server::OwnerLink& owner);
/// The front's end of the socket for samples.
[[nodiscard]] int samples_socket(const Inside& in);
/// A TCP socket in that state.
[[nodiscard]] bool is_tcp(int fd, std::uint8_t state);
/// A message of zeros with descriptors. False: it was not sent.
[[nodiscard]] bool send_with(int socket, const std::vector<int>& descriptors, std::size_t bytes);
/// A held proxy that presses as the controller of the suite does.
[[nodiscard]] server::ProxySample held(std::uint32_t epoch, std::uint64_t seq);

struct Mode {
  std::string_view name;
  void (*run)(Inside& in);
};
extern const std::vector<Mode> kAllowedModes;     ///< allowed.cpp
extern const std::vector<Mode> kCallModes;        ///< calls.cpp
extern const std::vector<Mode> kCrossingModes;    ///< crossing.cpp
extern const std::vector<Mode> kDescriptorModes;  ///< descriptors.cpp
extern const std::vector<Mode> kLinkModes;        ///< link.cpp
extern const std::vector<Mode> kProcessModes;     ///< process.cpp

}  // namespace haptic::hostile
