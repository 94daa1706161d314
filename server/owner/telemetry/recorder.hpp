#pragma once
/// Scene.record: every tick of one device as a row of a CSV file, composed on the telemetry's drain
/// and written on a thread of its own.
///
/// Columns, in this order:
///
///   time_s               since the first recorded tick, on the server's steady clock
///   one or more per field of v1::DeviceState, in the order of proto/haptic/v1/session.proto
///   damping_gain         g_d, 0..1
///   tau_damping_ACT_n    damping's part of tau_a, N or N m
///   lateness_us, skipped of the loop
///   tau_R_ACT_n          with compare_renderers, for R in standard, null_space, subspace_linear,
///                        subspace_exact: see renderer_comparison.hpp; nan if f has no value at q
///
/// A field's column is named FIELD_UNIT, and FIELD_LABEL_UNIT per DoF, actuated DoF or virtual
/// coordinate if it has an axis: gain, proxy_age_us, tau_a_l_x_n, stiffness_in_effect_l_x_n_per_m,
/// x_probe_q_o1_mcp_rad. A field of a message has the message's name before it: tracker_age_us,
/// passivity_tank_j. q has the bare name of its DoF, l_x: a replayed device looks for that name, so
/// every recording can be played.
///
/// Numbers read back to the same bits. Enum values stand by name without their prefix, NONE for
/// UNSPECIFIED; bits by name, joined by '|'. A field that is absent has empty cells.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "haptic/schema/fields.hpp"
#include "haptic/v1/session.pb.h"
#include "server/owner/telemetry/background_file.hpp"
#include "server/owner/telemetry/renderer_comparison.hpp"
#include "server/owner/telemetry/telemetry.hpp"

namespace haptic::server {

class Recorder final : public RecordListener {
 public:
  /// Takes `file` over. `state`: of the record that comes next, each time. `comparison` absent: no
  /// columns of the other renderers. `realtime`: of the thread that writes (background_file.hpp).
  Recorder(const NewFile& file, const core::Kinematics& kinematics, const v1::DeviceState& state,
           std::unique_ptr<RendererComparison> comparison = nullptr, bool realtime = false);
  /// Writes what is left and closes. The recorder must have been removed from the telemetry.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The header line, without its newline.
  [[nodiscard]] static std::string header(const core::Kinematics& kinematics, bool compare);

  /// Appends a row; never waits for the disk. If writing fails (disk full) the recording ends
  /// there at a whole row, with one warning in the log; rows that a slow disk leaves no room for
  /// are lost, and counted in another.
  void on_record(const core::TickRecord& record) override;

  /// Rows in the file or on their way to it; rows that were lost.
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  void compose(const core::TickRecord& record);

  const schema::Labels labels_;
  const std::vector<schema::Leaf> leaves_;
  const std::unique_ptr<RendererComparison> comparison_;
  const v1::DeviceState& state_;
  BackgroundFile file_;
  std::string row_;  ///< kept for its capacity
  std::uint64_t rows_{0};
  std::uint64_t lost_{0};
  std::optional<core::TimePoint> start_{};
};

}  // namespace haptic::server
