#pragma once
/// Stage of a tick: kinematics, the proxy at `now`, and the subspace proxy q* that the renderer
/// wants the spring anchored at (core/METHOD.md#equations).

#include "haptic/core/rendering/block_map.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "haptic/core/rendering/force_error.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "local_proxy.hpp"
#include "session_settings.hpp"

namespace haptic::core {

/// Results that later stages read and that are too large to be recorded.
struct Displacement {
  Probe probe;     ///< J is of this tick only in the blocks in which `dx` is not 0
  const VecX& dx;  ///< x (-) x_probe, n_x; of this tick if Anchor::mapped and Anchor::in_the_way
  const BlockRenderer& renderer;
  /// Where the spring would be anchored if no contact held it back (rule per contact), n_q; null:
  /// none does.
  const VecQ* q_wish{nullptr};
};

class Rendering {
 public:
  /// The model must outlive this. Of the configuration it reads scene and projection.
  Rendering(const ProjectionModel& model, const PipelineConfig& config);

  /// `sample`: of the proxy in use. `in_use`: the anchor in use in the last tick, n_q; it stays if
  /// f has no value at q (core/METHOD.md#map-without-a-value).
  /// `moment`: this tick, and the sample's age, which moves contacts that have a velocity.
  [[nodiscard]] Anchor step(const LocalProxy::Moment& moment, const Sensed& sensed,
                            const ProxySnapshot& sample, const Settings& settings,
                            const VecQ& in_use) noexcept;
  /// Displacement of the last step; valid until the next, and as long as `sensed`.
  [[nodiscard]] Displacement displacement(const Sensed& sensed) const noexcept {
    return {{sensed.q, map_.x_probe(), map_.J(), {local_.contacts()}},
            dx_,
            renderer_,
            projection_.contradicted ? &projection_.q_wish : nullptr};
  }

 private:
  /// x_probe, and the proxy `x` as the sample's local model moves it.
  void locate(const LocalProxy::Moment& moment, const Sensed& sensed, const ProxySnapshot& sample,
              Anchor& now) noexcept;
  /// q*, something being in the way and f having a value. False: it is not finite.
  [[nodiscard]] bool project(const Sensed& sensed, const Settings& settings, Anchor& now) noexcept;
  /// Nothing of the displacement stretches a spring of a motor, though q* is where x asks for it.
  [[nodiscard]] bool is_unfelt(const VecQ& q) const noexcept;
  /// Anchor::force_error.
  void bound(const Sensed& sensed, const Settings& settings, Anchor& now) noexcept;
  /// Blocks whose J this tick reads.
  [[nodiscard]] BlockSet needs_J(const Settings& settings) const noexcept;

  const ProjectionModel& model_;
  const bool separable_;  ///< nothing ties the blocks together
  BlockMap map_;
  LocalProxy local_;
  BlockRenderer renderer_;
  ForceError force_error_;
  BlockSet reached_{0};  ///< blocks that the planes in use can hold
  BlockSet free_{0};     ///< Anchor::free of the last step
  BlockSet has_J_{0};    ///< blocks with J of the last project()
  VecX dx_{};
  Projection projection_{};
  bool anchored_{false};  ///< q* is of the proxy in use
  bool solve_{true};      ///< the proxy changed since the renderer last saw it
};

}  // namespace haptic::core
