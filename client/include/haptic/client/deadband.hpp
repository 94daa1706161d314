#pragma once
/// Which samples the server needs. It goes on with a sample's planes at 1 kHz, so a sample that
/// says what the server finds by itself is no news.

#include <chrono>
#include <cstdint>
#include <deque>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

/// A sample is no news if it says the same as each sample that the server may use: the one that the
/// newest state used, and all later ones, because any of those may have come or be lost. Two
/// samples say the same if they have one mode and, held, are within the width of each other and
/// free in the same coordinates (Proxy::held); in planes mode, if
///
/// - the planes are the same by number and id, curved or not as before, as soft within a tenth, and
///   known at least as well (`uncertainty`);
/// - the surfaces lie within the width of each other at the proxy, now and after as long again as
///   since the sample that the newest state used;
/// - so do the proxies, for the probe now, and for one as far again ahead of it as it came since
///   that sample. They are the server's: solved from the planes in the metric 1, and anchored if a
///   plane has an id.
///
/// Always news: an object that is pushed (`mass`), because each sample begins its motion again; a
/// proxy that is not free and whose probe is not known; planes that do not say where the proxy is,
/// but for a shift of the gap of the only one that is touched; and a sample after which the next
/// one might come too late to be fresh.
class Deadband {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// `width`: m or rad, of each coordinate; 0: every sample is news. `rate_hz`: of publish().
  Deadband(std::vector<VirtualCoordinate> coordinates, double width, double rate_hz);

  /// A stream begins, with this limit of freshness, and what the server has is not known.
  void begin(std::chrono::nanoseconds fresh_end);
  /// A state used sample `seq`; 0: none.
  void used(std::uint64_t seq);
  /// Whether a sample is news. If so it counts as sent `now` under the number `seq`, above all
  /// before. `x_probe`: what it was computed from; empty: not known.
  [[nodiscard]] bool is_news(std::uint64_t seq, const Proxy& proxy,
                             const std::vector<double>& x_probe, TimePoint now);

 private:
  /// What the server makes of a sample.
  struct Law {
    std::uint64_t seq{0};
    TimePoint at{};
    Proxy proxy{};
    std::vector<double> probe{};   ///< beside proxy.position, or the held one's; empty: not known
    std::vector<double> anchor{};  ///< the client's own proxy less what the planes say
  };
  [[nodiscard]] Law law_of(std::uint64_t seq, const Proxy& proxy,
                           const std::vector<double>& x_probe, TimePoint now) const;
  [[nodiscard]] bool shifts_one_gap(const Proxy& proxy, std::vector<double> anchor) const;
  [[nodiscard]] bool stays_fresh(TimePoint now) const;
  [[nodiscard]] std::vector<double> away(const std::vector<double>& to,
                                         const std::vector<double>& from) const;
  [[nodiscard]] std::vector<double> solve(const Proxy& proxy, const std::vector<double>& probe,
                                          double t) const;
  [[nodiscard]] std::vector<double> predict(const Law& law, const std::vector<double>& probe,
                                            double t) const;
  [[nodiscard]] std::vector<bool> free(const Law& law) const;
  [[nodiscard]] bool near(const std::vector<double>& a, const std::vector<double>& b) const;
  [[nodiscard]] bool same_surface(const Plane& told, const Plane& now, const Law& old,
                                  const Law& law, double ahead) const;
  [[nodiscard]] bool same(const Law& old, const Law& law) const;

  std::vector<VirtualCoordinate> coordinates_;
  double width_;
  double period_;          ///< s
  double fresh_end_{0.0};  ///< s
  std::uint64_t used_{0};
  std::deque<Law> laws_{};  ///< that the server may use: from used_ on, if that is known
};

}  // namespace haptic::client
