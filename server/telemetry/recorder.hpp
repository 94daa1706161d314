#pragma once
/// Scene.record: every tick of one device as a row of a CSV file, composed on the telemetry's drain
/// and written on a thread of its own.
///
/// The header, in this order. DOF stands for each DoF's name ("l_x"), ACT for each actuated DoF's,
/// COORD for each virtual coordinate's; UNIT is m or rad, FORCE is n (N) or n_m (N m).
///
///   time_s                   since the first recorded tick, on the server's steady clock
///   tick                     counts from 1; a step of more than one: records were dropped
///   state                    INIT, IDLE, ARMED, ENGAGING, ENGAGED, RELEASING, FAULT, CLOSING
///   staleness                FRESH, HOLD, FADE, LOST
///   proxy_age_us             age of the newest proxy; 0 while there is none
///   mode                     NONE, HELD, FREE, PLANES
///   gain, damping_gain       g and g_d, 0..1
///   DOF                      q in m or rad, one column per DoF under its bare name: what a
///                            replayed device looks for, so that every recording can be played
///   q_dot_ACT_UNIT_per_s     rate of the actuated DoFs
///   x_probe_COORD_UNIT       haptic probe f(q)
///   x_COORD_UNIT             proxy in use; empty while there is none
///   q_star_DOF_UNIT          subspace proxy in use
///   tau_elastic_ACT_FORCE, tau_damping_ACT_FORCE, tau_a_ACT_FORCE
///   projection               NONE, EXACT, CONVERGED, CAPPED, UNREACHABLE, ILL_CONDITIONED,
///                            RANK_DEFICIENT, MAP_FAILED
///   faults, limiters         reasons joined by '|'; empty: none
///   storage_j                V of the spring in use; empty where the scene has neither tank nor
///                            observer, and so are the next three
///   tank_j                   level of the energy tank; below 0: debt (core/METHOD.md#energy-tank)
///   tank_scale               deviation in use by deviation wanted; below 1: the tank held it back
///   observed_j               E_obs of the passivity observer (core/METHOD.md#passivity-observer)
///   certificate              of the linearised method (core/METHOD.md#exact-derivatives):
///   COMPUTED, or why it is not; empty
///                            where the scene does not ask for it
///   certificate_margin, certificate_block   while COMPUTED, else empty
///   lateness_us, skipped     of the loop
///
/// where the scene has a tracker also (its pose itself is the palm's part of q):
///   tracker_seq              of the pose in use; 0: none came so far
///   tracker_age_us           of that pose; 0 while there is none
///   tracker_staleness        FRESH, HOLD, FADE, LOST: of that age
///
/// with compare_renderers also, for R in standard, null_space, subspace_linear, subspace_exact:
///   tau_R_ACT_FORCE          see renderer_comparison.hpp; nan where f has no value at q
///
/// The finger exoskeleton's header thus reads: time_s,tick,state,staleness,proxy_age_us,mode,gain,
/// damping_gain,l_x,q_B,q_dot_l_x_m_per_s,x_probe_q_o1_mcp_rad,x_probe_q_o2_pip_rad,
/// x_q_o1_mcp_rad,x_q_o2_pip_rad,q_star_l_x_m,q_star_q_B_rad,tau_elastic_l_x_n,tau_damping_l_x_n,
/// tau_a_l_x_n,projection,faults,limiters,storage_j,tank_j,tank_scale,observed_j,
/// certificate,certificate_margin,certificate_block,lateness_us,skipped[,tau_standard_l_x_n,
/// tau_null_space_l_x_n,tau_subspace_linear_l_x_n,tau_subspace_exact_l_x_n].
///
/// Numbers have full precision: reading them back gives the same bits.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "haptic/core/model/kinematics.hpp"
#include "server/telemetry/background_file.hpp"
#include "server/telemetry/renderer_comparison.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

class Recorder final : public RecordListener {
 public:
  /// `comparison` absent: no columns of the other renderers. `tracked`: the scene has a tracker.
  /// Throws SceneError where `file` cannot be created (path and the system's reason).
  Recorder(const std::filesystem::path& file, std::shared_ptr<const core::Kinematics> kinematics,
           std::unique_ptr<RendererComparison> comparison = nullptr, bool tracked = false);
  /// Writes what is left and closes. The recorder must have been removed from the telemetry.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The header line, without its newline.
  [[nodiscard]] static std::string header(const core::Kinematics& kinematics, bool compare,
                                          bool tracked = false);

  /// Appends a row; never waits for the disk. Where writing fails (disk full) the recording ends
  /// there, with one warning in the log; rows that a slow disk leaves no room for are lost, and
  /// counted in another.
  void on_record(const core::TickRecord& record) override;

  /// Rows in the file or on their way to it; rows that were lost.
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  void compose(const core::TickRecord& record);

  const std::filesystem::path path_;
  const std::shared_ptr<const core::Kinematics> kinematics_;
  const std::unique_ptr<RendererComparison> comparison_;
  const bool tracked_;
  BackgroundFile file_;
  std::string row_;  ///< kept for its capacity
  std::uint64_t rows_{0};
  std::uint64_t lost_{0};
  std::optional<core::TimePoint> start_{};
};

}  // namespace haptic::server
