#pragma once
/// A simulation at the end of a network that uses all that a client may: in turns it is free, holds
/// a point, and tells rigid, soft, moving, curved and pushed contacts; its samples are late, lost
/// and out of order, and at times it is silent. The same seed and the same device give the same
/// samples.

#include <cstdint>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::report {

class TouchingClient {
 public:
  /// `config` must outlive it.
  TouchingClient(const core::PipelineConfig& config, std::uint64_t seed);

  /// A new lease: what is on the way is lost, and the stream's health begins again.
  void begin_lease(std::uint32_t tenure, core::ProxySnapshot& proxy);
  /// Once a tick: looks at the newest record if it is time to, and writes into `proxy` what has
  /// arrived by `now`.
  void step(const core::TickRecord& newest, core::TimePoint now, core::ProxySnapshot& proxy);

 private:
  enum class Touch : std::uint8_t {
    kFree,
    kHeld,
    kRigid,
    kSoft,
    kMoving,
    kCurved,
    kPushed,
    kSilent,
  };
  /// A wall through the place of the first coordinates that it names.
  struct Wall {
    core::VecX normal{};     ///< n_x
    double offset{0.0};      ///< gap = offset - normal^T x
    double mobility{0.0};    ///< normal^T W^-1 normal
    int first{0}, count{0};  ///< coordinates that it names
    double swing{0.0};       ///< by which the offset swings
    double swing_rate{0.0};  ///< rad/s
  };
  struct Sent {
    core::TimePoint arrives{};
    core::ProxySnapshot sample{};
  };

  void begin_phase(const core::VecX& x_probe, core::TimePoint now);
  [[nodiscard]] Wall make_wall(const core::VecX& x_probe);
  void look(const core::TickRecord& newest, core::TimePoint now);
  [[nodiscard]] core::PlaneSet told(const core::VecX& x, double since_s);
  void tell_laws(core::PlaneSet& planes);
  [[nodiscard]] double offset(const Wall& wall, double since_s) const;
  [[nodiscard]] bool planes_touch() const noexcept { return touch_ >= Touch::kRigid; }

  const core::PipelineConfig& config_;
  haptic::test::Random random_;
  std::uint64_t phase_{0};
  core::VecX length_{};  ///< n_x, what counts as a touch's depth: m, rad
  core::Duration period_{}, delay_{};
  Touch touch_{Touch::kFree};
  core::TimePoint phase_began_{}, phase_ends_{}, next_look_{};
  std::vector<Wall> walls_{};
  std::vector<Sent> on_the_way_{};
  core::TimePoint last_arrival_{};
  std::uint32_t tenure_{0};
  std::uint64_t seq_{0};
};

}  // namespace haptic::report
