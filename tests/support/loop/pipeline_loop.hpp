#pragma once
/// The real Pipeline at 1 kHz in virtual time between a device that is somewhere and a client
/// behind a network, and the book of the energy that the held force gives.

#include "haptic/core/tick/pipeline.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::test {

/// Work of a force that is held over each tick on the user (core/METHOD.md#passivity-observer:
/// exact, no velocity). J.
class EnergyBook {
 public:
  /// `damping`: what the device's own takes at each actuator, N s/m or N m s/rad.
  explicit EnergyBook(double damping) : damping_(damping) {}
  /// Over one tick of `dt`, n_a each.
  void add(const core::VecA& tau_held, const core::VecA& way, double dt) noexcept;
  /// Begins a cycle: given() and net() count from here, most_net() goes on.
  void begin_cycle() noexcept;

  [[nodiscard]] double given() const noexcept { return given_ - given_before_; }
  /// given() less what the device's own damping took.
  [[nodiscard]] double net() const noexcept { return net_ - net_before_; }
  /// Largest value over time of what was given net since the first add(): what a tank bounds.
  [[nodiscard]] double most_net() const noexcept { return most_net_; }
  [[nodiscard]] double most_given() const noexcept { return most_given_; }
  [[nodiscard]] double given_in_all() const noexcept { return given_; }
  [[nodiscard]] double net_in_all() const noexcept { return net_; }

 private:
  double damping_;
  double given_{0.0}, net_{0.0}, given_before_{0.0}, net_before_{0.0};
  double most_net_{0.0}, most_given_{0.0};
};

/// The device is always armed, and has a sample every tick.
class PipelineLoop {
 public:
  static constexpr double kTick_s = 1e-3;

  /// `device_damping`: of each actuated DoF, for the book.
  PipelineLoop(const core::PipelineConfig& config, const ClientSettings& client,
               double device_damping);

  /// One tick with the device at q (n_q): books what the last force did on the way here, the client
  /// looks and delivers, the pipeline answers. Throws SceneError if the device cannot be there.
  const core::TickRecord& tick(const core::VecQ& q);
  /// Asks for force, at the next tick.
  void engage() noexcept { ++input_.command.engage_id; }
  /// Throws SceneError unless force is on.
  void require_engaged() const;

  [[nodiscard]] double time_s() const noexcept { return kTick_s * ticks_; }
  [[nodiscard]] double tau() const noexcept { return tau_[0]; }  ///< held now by the first actuator
  [[nodiscard]] const core::VecA& tau_a() const noexcept { return tau_; }  ///< by all, n_a
  [[nodiscard]] const core::VecX& x_probe() const noexcept { return x_probe_; }
  [[nodiscard]] const core::MatXQ& J() const noexcept { return J_; }
  [[nodiscard]] EnergyBook& energy() noexcept { return energy_; }
  [[nodiscard]] const core::TickRecord& record() const noexcept { return record_; }
  [[nodiscard]] const core::ProxySnapshot& proxy() const noexcept { return proxy_; }

 private:
  core::Pipeline pipeline_;
  RemoteClient client_;
  EnergyBook energy_;
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::TickRecord record_{};
  core::VecX x_probe_{};
  core::MatXQ J_{};
  core::VecA tau_{}, last_q_a_{};  ///< n_a
  int ticks_{0};
};

}  // namespace haptic::test
