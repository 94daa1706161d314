#pragma once
/// The answer to `health` of the local control socket: what the owner knows, next to what the front
/// claims. A front that plays a client cannot be told from one that has it by what it sends: the
/// operator compares its samples and sessions with the clients that there are.

#include <array>
#include <string>
#include <vector>

#include "server/owner/rights/owner.hpp"

namespace haptic::server {

/// The front as the link sees it.
struct FrontView {
  bool serves{false};
  pid_t process{0};         ///< 0: none
  std::uint64_t number{0};  ///< of fronts that served
  core::TimePoint since{};  ///< it serves
  std::string why{};        ///< why the last one ended, or could not serve
};

/// One thread.
class LocalHealth {
 public:
  /// `addresses`: as the server tells them. `owner` must outlive this.
  LocalHealth(const Owner& owner, std::vector<std::string> addresses);

  /// Looks at the counters, for the rates; at least once a second.
  void look(core::TimePoint now);
  /// "ok", then lines of fields with tabs between them, of which the last may have any text:
  ///
  ///   front    serves or none, number, process, age in s, why the last one ended
  ///   address  one that is served
  ///   device   name, state, sessions, observers, samples accepted, per second, refused, per
  ///            second, the controller's name
  ///
  /// Sessions, observers and the controller's name are what the front claims.
  [[nodiscard]] std::string text(const FrontView& front, core::TimePoint now);

 private:
  struct Counts {
    std::uint64_t accepted{0}, refused{0};
  };
  struct Look {
    core::TimePoint at{};
    std::vector<Counts> devices{};
  };
  [[nodiscard]] Look counted(core::TimePoint now) const;

  const Owner& owner_;
  const std::vector<std::string> addresses_;
  std::array<Look, 2> looks_{};  ///< the newest last
};

}  // namespace haptic::server
