#pragma once
/// A simulation behind a network, in virtual time: at its own rate it sees the haptic probe,
/// computes the proxy (the probe clipped at stops or kept out of walls), and its sample arrives at
/// the pipeline after a delay. An older sample never replaces a newer one.

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"
#include "haptic/core/tick/tick_input.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::test {

/// Knowledge of the simulation when it computed a sample.
struct Frame {
  double seen_s{0.0};      ///< when it looked at the device
  double computed_s{0.0};  ///< when it computed, half the delay later
  double arrives_s{0.0};   ///< when the pipeline gets it
  std::uint64_t tick{0};   ///< of the look, as the pipeline counts
  std::uint64_t seq{0};    ///< 1, 2, ...
  core::VecQ q{};          ///< device, n_q
  core::VecX x_probe{};    ///< haptic probe, n_x
  core::VecX x{};          ///< proxy, n_x
  bool contact{false};     ///< x is not simply the probe
  core::PlaneSet walls{};  ///< as the simulation had them; none: its stops counted
  bool anchored{false};    ///< they are contacts with ids
};

/// Facts that a law between two samples may look at.
struct Between {
  const Frame& newest;
  const Frame& previous;      ///< the one delivered before; the newest itself at first
  double since_arrival_s;     ///< of the newest
  const core::VecQ& q;        ///< now
  const core::VecX& x_probe;  ///< now
};

/// Computes the proxy at every tick outside the pipeline, which gets it as a held one. So laws that
/// hapticd does not offer can be measured on the real pipeline. Returns x, n_x.
using LocalLaw = std::function<core::VecX(const Between&)>;

struct ClientSettings {
  core::ProxyMode mode{core::ProxyMode::kHeld};  ///< held or planes
  /// The planes of the stops in contact alone, and of walls the one that the client library derives
  /// for a whole finger; else all of them, always.
  bool only_in_contact{false};
  core::VecX stop{};  ///< n_x, x_i <= stop_i; infinity: none
  /// > 0: the stops give way, gamma of each; planes mode tells it, as contacts that are anchored.
  double compliance{0.0};
  double told_compliance{0.0};  ///< what it tells instead of that; 0: the truth
  bool told_rigid{false};       ///< they are told as rigid planes through the client's own proxy
  std::optional<double> uncertainty{};  ///< of the compliance, as it tells it
  bool anchored{true};     ///< a client that tells compliances says which tick it computed from
  core::PlaneSet walls{};  ///< instead of stops, in any direction; none: the stops count
  /// Instead of both: a curved object, as the planes that touch it where it is nearest to x_probe.
  std::function<core::PlaneSet(const core::VecX& x_probe)> object{};
  /// Instead of all of these: from what the frame knows of the device it computes x, walls (which
  /// are sent as they are), contact and anchored. With a mode of held, x alone is sent.
  std::function<void(Frame& frame)> simulate{};
  double rate_hz{60.0};      ///< > 0
  double delay_s{0.0};       ///< from the look at the device to the sample's arrival, >= 0
  double delay_growth{0.0};  ///< of the delay, s per s
  double jitter{0.3};        ///< of the period, uniform, +-; in [0, 1)
  double lost{0.0};          ///< share of samples that never arrive
  bool disorder{false};      ///< samples come twice, late by up to two periods and out of order
  std::uint64_t seed{7};
  LocalLaw between{};  ///< none: the pipeline's own local model (core/METHOD.md#local-models)
};

class RemoteClient {
 public:
  /// `filtered`: the state's pose is not the reading, because the pipeline filters it.
  explicit RemoteClient(ClientSettings settings, bool filtered = false);

  /// One tick at `t_s`: writes into `proxy` what has arrived. `now` is the pipeline's clock; t_s
  /// never falls. A client whose samples take less than a tick looks at the device first, if it is
  /// time to and the reading is what the state would tell.
  void step(double t_s, core::TimePoint now, const core::VecQ& q, const core::VecX& x_probe,
            core::ProxySnapshot& proxy);
  /// The end of that tick: any other client sees the device as the pipeline's state tells it. So a
  /// sample without delay is used in the next tick, as of a client on loopback.
  void look_after(double t_s, const core::VecQ& q, const core::VecX& x_probe);

 private:
  [[nodiscard]] bool is_time_to_look(double t_s) const noexcept;
  void look(double t_s, const core::VecQ& q, const core::VecX& x_probe);
  void deliver(const Frame& frame, core::TimePoint now, core::ProxySnapshot& proxy) const;
  [[nodiscard]] bool tells_compliance() const noexcept {
    return settings_.compliance > 0.0 && !settings_.told_rigid;
  }
  void write_planes(const Frame& frame, core::PlaneSet& planes) const;
  /// Place of the virtual object, and what keeps it there.
  void put_proxy(Frame& frame);

  ClientSettings settings_;
  bool looks_first_;  ///< in step()
  Random random_;
  std::shared_ptr<const core::ConfigurationSpace> space_{};  ///< of the first look
  std::optional<core::PlaneProjection> projection_{};
  std::vector<Frame> on_the_way_{};
  Frame newest_{}, previous_{};
  double next_look_s_{0.0};
  std::uint64_t tick_{0};
  std::uint64_t seq_{0};
};

}  // namespace haptic::test
