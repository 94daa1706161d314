#pragma once
/// Contacts for a simulation that only knows its proxy: how far the proxy follows the probe along
/// the normal, estimated from the simulation's own samples.

#include <deque>
#include <vector>

#include "haptic/client/planes.hpp"

namespace haptic::client {

/// One contact per block that is held, in units of x: the plane of derive_planes(), with the
/// compliance C / (1 - C), C = dx/dx_probe along the normal.
///
/// C is the slope of the proxies over the probes of up to the last 8 samples in which the probe
/// moved one way, if it moved by kMotion or more: below that noise and the solver's rest decide. It
/// is told on the stiff side: less one standard error, and from 0 (rigid) to kSoftest. A proxy that
/// lags behind its solver looks softer or stiffer than it is, so the force errs more than that of a
/// client that knows its stiffness (contact.hpp). Without motion C stays what it was, also over a
/// free sample, and it is 0 at first. A block is taken to touch one object.
class ContactEstimator {
 public:
  static constexpr double kMotionMetres = 5e-4, kMotionRadians = 1e-2;
  static constexpr double kSoftest = 0.9;  ///< C; compliance 9

  /// `blocks` empty: all coordinates are one block.
  ContactEstimator(std::vector<VirtualCoordinate> coordinates, std::vector<Block> blocks);

  /// A held sample: the proxy x computed from x_probe, one value per coordinate each. The id of a
  /// block's contact is its number from 1 on. If a size does not fit, there is none.
  [[nodiscard]] std::vector<Plane> contacts(const std::vector<double>& x,
                                            const std::vector<double>& x_probe);
  /// A free sample: what follows is another touch.
  void free() noexcept;

 private:
  struct Sample {
    std::vector<double> x{}, x_probe{};
  };
  struct Estimate {
    Block block{};
    std::deque<Sample> samples{};  ///< the newest last
    double follows{0.0};           ///< C
  };
  void estimate(Estimate& block, const std::vector<double>& normal) const;

  std::vector<VirtualCoordinate> coordinates_;
  std::vector<Estimate> estimates_{};
};

}  // namespace haptic::client
