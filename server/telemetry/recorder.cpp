#include "server/telemetry/recorder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "haptic/core/error.hpp"

namespace haptic::server {

namespace {

std::string_view unit_name(core::Unit unit) { return unit == core::Unit::kMetre ? "m" : "rad"; }
std::string_view force_unit(core::Unit unit) { return unit == core::Unit::kMetre ? "n" : "nm"; }

std::string_view name_of(core::Staleness level) {
  switch (level) {
    case core::Staleness::kFresh: return "FRESH";
    case core::Staleness::kHold: return "HOLD";
    case core::Staleness::kFade: return "FADE";
    case core::Staleness::kLost: return "LOST";
  }
  return "UNKNOWN";
}

std::string_view mode_of(const core::TickRecord& record) {
  if (record.x.size() == 0) return "none";
  return record.input.proxy.mode == core::ProxyMode::kFree ? "free" : "held";
}

constexpr core::RendererKind kCompared[] = {
    core::RendererKind::kStandard, core::RendererKind::kNullSpace,
    core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact};

}  // namespace

Recorder::Recorder(const DeviceUnit& unit, const std::filesystem::path& file,
                   bool compare_renderers)
    : kinematics_(*unit.config().kinematics), file_(std::fopen(file.c_str(), "w")) {
  if (!file_) {
    throw core::DeviceError("record.file = \"" + file.string() + "\": " + std::strerror(errno) +
                            "; must be a file that can be written");
  }
  std::setvbuf(file_.get(), nullptr, _IOFBF, 1 << 20);
  if (compare_renderers) {
    for (const core::RendererKind kind : kCompared) renderers_.emplace_back(kind, kinematics_);
  }
  header();
}

Recorder::~Recorder() = default;

void Recorder::header() {
  const auto& dofs = kinematics_.dofs();
  const core::DofLayout& layout = kinematics_.layout();
  std::string line = "time_s,tick,state,staleness,proxy_age_us,mode,gain,damping_gain";
  const auto per_dof = [&](std::string_view prefix) {
    for (const core::DofSpec& dof : dofs) {
      line.append(",").append(prefix).append(dof.name).append("_").append(unit_name(dof.unit));
    }
  };
  const auto per_actuated = [&](std::string_view prefix, bool force) {
    for (int i = 0; i < layout.n_a(); ++i) {
      const core::DofSpec& dof = dofs[static_cast<std::size_t>(layout.actuated(i))];
      line.append(",").append(prefix).append(dof.name).append("_");
      line.append(force ? force_unit(dof.unit) : unit_name(dof.unit));
      if (!force) line.append("_per_s");
    }
  };
  const auto per_coordinate = [&](std::string_view prefix) {
    for (const core::Coordinate& c : kinematics_.space().coordinates()) {
      line.append(",").append(prefix).append(c.name).append("_").append(unit_name(c.unit));
    }
  };
  per_dof("q_");
  per_actuated("qdot_", false);
  per_coordinate("xprobe_");
  per_coordinate("x_");
  per_dof("qstar_");
  per_actuated("tau_elastic_", true);
  per_actuated("tau_damping_", true);
  per_actuated("tau_", true);
  line.append(",projection,faults,limiters,lateness_us,skipped");
  for (const core::Renderer& renderer : renderers_) {
    per_actuated("tau_" + std::string(core::name(renderer.kind())) + "_", true);
  }
  line.append("\n");
  std::fwrite(line.data(), 1, line.size(), file_.get());
}

void Recorder::text(std::string_view value) { row_.append(",").append(value); }

void Recorder::number(double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  row_.append(",").append(digits, end);
}

/// `count` values, and nan for those that are missing up to `wanted`.
void Recorder::numbers(const double* values, int count, int wanted) {
  for (int i = 0; i < wanted; ++i) {
    number(i < count ? values[i] : std::numeric_limits<double>::quiet_NaN());
  }
}

void Recorder::on_record(const core::TickRecord& record) {
  if (!has_first_) {
    first_ = record.input.now;
    has_first_ = true;
  }
  const int n_q = kinematics_.layout().n_q(), n_a = kinematics_.layout().n_a();
  const int n_x = kinematics_.space().n_x();
  const auto vector = [this](const auto& v, int wanted) {
    numbers(v.data(), static_cast<int>(v.size()), wanted);
  };
  row_.clear();
  number(core::seconds(record.input.now - first_));
  row_.erase(0, 1);  // no comma before the first column
  number(static_cast<double>(record.tick));
  text(core::name(record.state));
  text(name_of(record.staleness));
  number(core::seconds(record.proxy_age) * 1e6);
  text(mode_of(record));
  number(record.gain);
  number(record.damping_gain);
  vector(record.q, n_q);
  vector(record.q_a_dot, n_a);
  vector(record.x_probe, n_x);
  vector(record.x, n_x);
  vector(record.q_star, n_q);
  vector(record.tau_elastic, n_a);
  vector(record.tau_damping, n_a);
  vector(record.tau_a, n_a);
  number(static_cast<double>(record.projection));
  number(record.faults.bits());
  number(record.limiters.bits());
  number(core::seconds(record.input.loop.lateness) * 1e6);
  number(record.input.loop.skipped);
  if (!renderers_.empty()) comparison(record);
  row_.append("\n");
  std::fwrite(row_.data(), 1, row_.size(), file_.get());
}

void Recorder::comparison(const core::TickRecord& record) {
  const core::DofLayout& layout = kinematics_.layout();
  const core::RenderSettings& settings = record.input.settings;
  core::VecX x_probe, dx;
  core::MatXQ J;
  const bool held = mode_of(record) == "held" &&
                    kinematics_.evaluate(record.q, x_probe, J) == core::MapStatus::kOk;
  const bool changed = record.input.proxy.seq != compared_seq_;
  if (held) {
    kinematics_.space().difference(record.x, x_probe, dx);
    compared_seq_ = record.input.proxy.seq;
  }
  core::Projection projection;
  for (core::Renderer& renderer : renderers_) {
    if (held) {
      renderer.project(core::Probe{record.q, x_probe, J}, record.x, dx, settings.stiffness, changed,
                       projection);
    }
    for (int i = 0; i < layout.n_a(); ++i) {
      const int a = layout.actuated(i);
      const double tau =
          held ? record.gain * settings.stiffness[i] * (projection.q_star[a] - record.q[a]) : 0.0;
      number(std::clamp(tau, -settings.force_limit[i], settings.force_limit[i]));
    }
  }
}

}  // namespace haptic::server
