#pragma once
/// Objects of the study rtt as a simulation knows them: where they let the probe be, and what they
/// are told as. The proxy is solved here by closed forms, apart from the server's solver.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic/client/contact.hpp"
#include "haptic/core/types.hpp"

namespace haptic::report {

/// N/m: Z_q of the devices that move in metres.
inline constexpr double kRttCoupling = 1500.0;
inline constexpr double kRttSoft = 500.0;  ///< N/m, of soft objects

/// Reach of what a client tells ahead: how far, and for when.
struct RttHorizon {
  double metres{0.0};
  double seconds{0.0};
};

class RttObject {
 public:
  virtual ~RttObject() = default;
  /// The world moves on to `t` s, when the device is at x_probe: once per tick. An object that this
  /// moves is one for all who look at it: a simulation that integrates every state it gets is where
  /// the object is, of the tick that it looks at.
  virtual void advance(double /*t*/, const core::VecX& /*x_probe*/) {}
  /// The simulation's own proxy at `t` s, n_x; the probe itself if it touches nothing. t never
  /// falls.
  [[nodiscard]] virtual core::VecX proxy(double t, const core::VecX& x_probe) = 0;
  /// The contacts within `near.metres` of the proxy x, at `t`, for a sample that is in use about
  /// `near.seconds` later.
  [[nodiscard]] virtual std::vector<client::Plane> contacts(double t, const core::VecX& x,
                                                            const RttHorizon& near) const = 0;
  /// Distance of the probe from the surface, m; < 0: inside.
  [[nodiscard]] virtual double clearance(double t, const core::VecX& x_probe) const = 0;
};

using RttMaker = std::function<std::shared_ptr<RttObject>()>;

// One coordinate: a surface at 0, the object beyond it.
[[nodiscard]] std::unique_ptr<RttObject> rtt_rigid_wall();
[[nodiscard]] std::unique_ptr<RttObject> rtt_soft_wall();  ///< 500 N/m
/// Force 5000 N/m^1.5 times depth^1.5: 5 N at 10 mm. Told as one contact with the slope at the
/// proxy's depth, at least that at 3 mm.
[[nodiscard]] std::unique_ptr<RttObject> rtt_stiffening_wall();
/// The same, told as springs in parallel that begin at six depths.
[[nodiscard]] std::unique_ptr<RttObject> rtt_stiffening_springs();
// The surface moves by itself, 5 mm at 0.5 Hz; told with its mean speed until the sample's use.
[[nodiscard]] std::unique_ptr<RttObject> rtt_moving_rigid_wall();
[[nodiscard]] std::unique_ptr<RttObject> rtt_moving_soft_wall();
/// Two coordinates: a disc of radius 30 mm and 500 N/m below the x axis, its top at the origin.
[[nodiscard]] std::unique_ptr<RttObject> rtt_disc();
/// Two coordinates, one per finger, along one line: a block of 40 mm and 500 N/m between them that
/// nothing else holds, without mass.
[[nodiscard]] std::unique_ptr<RttObject> rtt_block();
/// One coordinate: a mass with a surface of 500 N/m, held by a spring and a damper, pushed by the
/// finger.
struct RttPushed {
  double mass{0.2}, ground{200.0};  ///< kg, N/m
  double damping{0.0};              ///< N s/m; 0: 0.3 of the critical damping
  enum Told { kSurface, kVelocity, kLaw } told{kLaw};
  double told_mass{1.0};    ///< by the true one
  double disturbance{0.0};  ///< N, at 0.5 Hz
  bool own_steps{false};    ///< it moves when its proxy is asked for, by one explicit step
};
[[nodiscard]] std::unique_ptr<RttObject> rtt_pushed(const RttPushed& what);
/// Two coordinates: the block with a mass, on a damper, told as a contact of each finger with a law
/// of its own.
[[nodiscard]] std::unique_ptr<RttObject> rtt_pushed_block(const RttPushed& what);
/// Two joints: the soft finger of the shipped example, with its twelve pads.
[[nodiscard]] std::unique_ptr<RttObject> rtt_soft_finger();

[[nodiscard]] std::vector<double> to_std(const core::VecX& x);
/// A point that is itself the first coordinates.
[[nodiscard]] client::PointMap rtt_point_of(const core::VecX& x);
/// Depth d of a proxy whose probe is `depth` beyond the surface of a spring k: K (depth - d) = k d.
[[nodiscard]] double rtt_share(double depth, double k);

}  // namespace haptic::report
