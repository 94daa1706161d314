#pragma once
/// Every tick as a row of a CSV file, written on the telemetry's thread.
///
/// Columns, in this order; <dof> and <coordinate> are the device's names, u their unit (m, rad), f the
/// unit of force of an actuated DoF (n, nm):
///   time_s, tick, state, staleness, proxy_age_us, mode, gain, damping_gain,
///   q_<dof>_<u>..., qdot_<actuated dof>_<u>_per_s..., xprobe_<coordinate>_<u>..., x_<coordinate>_<u>...,
///   qstar_<dof>_<u>..., tau_elastic_<dof>_<f>..., tau_damping_<dof>_<f>..., tau_<dof>_<f>...,
///   projection, faults, limiters, lateness_us, skipped
/// and with compare_renderers: tau_standard_<dof>_<f>..., tau_null_space_..., tau_subspace_linear_...,
/// tau_subspace_exact_...
/// The compared forces are what each renderer, without the direction guard, would give on this tick's q and x:
/// g Z_q S (q* - q) with the settings in effect, saturated at the force limit; slew, envelope and damping are
/// left out. time_s counts from the first row. x is empty (nan) where there is no proxy; mode is
/// none, held or free.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/projection/renderer.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

class Recorder final : public RecordListener {
 public:
  /// Throws DeviceError where the file cannot be written. `unit` must outlive the recorder.
  Recorder(const DeviceUnit& unit, const std::filesystem::path& file, bool compare_renderers);
  ~Recorder() override;

  void on_record(const core::TickRecord& record) override;

 private:
  void header();
  void number(double value);
  void numbers(const double* values, int count, int wanted);
  void text(std::string_view value);
  void comparison(const core::TickRecord& record);

  const core::Kinematics& kinematics_;
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<core::Renderer> renderers_;
  std::string row_{};
  core::TimePoint first_{};
  bool has_first_{false};
  std::uint64_t compared_seq_{0};
};

}  // namespace haptic::server
