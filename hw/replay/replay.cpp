#include "hw/replay/replay.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"

namespace haptic::hw {
namespace {

core::Duration duration(double s) {
  return core::Duration(std::llround(s * 1e9));
}

ColumnSet dof_names(const core::Kinematics& kinematics) {
  ColumnSet names;
  for (const core::DofSpec& dof : kinematics.dofs()) names.push_back(dof.name);
  return names;
}

bool maps_joint_angles(const core::Kinematics& kinematics) {
  if (kinematics.space().n_x() != static_cast<int>(joint_angle_columns().size())) return false;
  core::VecQ q = core::VecQ::Zero(kinematics.layout().n_q());
  const core::VecX x = core::VecX::Zero(kinematics.space().n_x());
  return kinematics.inverse(x, q) != core::InverseStatus::kNotOffered;
}

std::string summary(const std::filesystem::path& file, const ReplayFacts& facts) {
  std::ostringstream text;
  text << "replay of " << file.filename().string() << ": " << facts.rows << " rows of "
       << (facts.joint_angles ? "joint angles" : "device states") << ", "
       << core::seconds(facts.length) << " s, " << facts.gaps << " gap(s)";
  if (facts.joint_angles) text << ", " << facts.replaced << " row(s) outside the reach replaced";
  return text.str();
}

}  // namespace

Replay::Replay(const ReplayConfig& config, std::shared_ptr<const core::Kinematics> kinematics)
    : kinematics_(std::move(kinematics)), repeat_(config.repeat) {
  info_.limits = device_limits(*kinematics_, config.max_effort);
  info_.limits.max_silence = duration(kLongestStep);
  info_.limits.silence_policy = core::SilencePolicy::kRampOut;
  info_.kind = "replay";
  info_.dofs = kinematics_->dofs();
  info_.moves = false;

  std::vector<ColumnSet> alternatives{dof_names(*kinematics_)};
  if (maps_joint_angles(*kinematics_)) alternatives.push_back(joint_angle_columns());
  MotionTable table = read_motion_csv(config.file, alternatives);
  facts_.rows = table.time_s.size();
  facts_.length = duration(table.time_s.back());
  facts_.joint_angles = table.alternative == 1;
  if (facts_.joint_angles) {
    bring_into_reach(table);
  } else {
    check_range(table, config.file);
  }
  cut_at_gaps(table);
  info_.model = summary(config.file, facts_);
  q_ = core::VecQ::Zero(kinematics_->layout().n_q());
}

void Replay::check_range(const MotionTable& table, const std::filesystem::path& file) const {
  for (std::size_t c = 0; c < table.values.size(); ++c) {
    const double lower = info_.limits.q_lower[static_cast<Eigen::Index>(c)];
    const double upper = info_.limits.q_upper[static_cast<Eigen::Index>(c)];
    for (std::size_t row = 0; row < facts_.rows; ++row) {
      const double value = table.values[c][row];
      if (value >= lower && value <= upper) continue;
      std::ostringstream text;
      text << file.string() << ":" << table.line[row] << ": column " << info_.dofs[c].name << " = "
           << value << ": must lie within the device's range, " << lower << " to " << upper;
      throw core::DeviceError(text.str());
    }
  }
}

void Replay::bring_into_reach(MotionTable& table) {
  core::VecQ q = core::VecQ::Zero(kinematics_->layout().n_q());
  core::VecX x(2);
  core::VecX reached(2);
  core::MatXQ J(2, kinematics_->layout().n_q());
  for (std::size_t row = 0; row < facts_.rows; ++row) {
    x << table.values[0][row], table.values[1][row];
    if (kinematics_->inverse(x, q) == core::InverseStatus::kExact) continue;
    ++facts_.replaced;
    if (kinematics_->evaluate(q, reached, J) != core::MapStatus::kOk) continue;
    table.values[0][row] = reached[0];
    table.values[1][row] = reached[1];
  }
}

void Replay::cut_at_gaps(const MotionTable& table) {
  std::size_t begin = 0;
  for (std::size_t row = 1; row <= facts_.rows; ++row) {
    const bool last = row == facts_.rows;
    if (!last && !is_gap(table.time_s[row - 1], table.time_s[row])) continue;
    if (!last) ++facts_.gaps;
    const auto part = [&](const std::vector<double>& all) {
      return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(begin),
                                 all.begin() + static_cast<std::ptrdiff_t>(row));
    };
    Stretch stretch{duration(table.time_s[begin]), duration(table.time_s[row - 1])};
    for (const auto& column : table.values) {
      stretch.column.emplace_back(part(table.time_s), part(column));
    }
    stretches_.push_back(std::move(stretch));
    begin = row;
  }
}

const Replay::Stretch* Replay::stretch_at(core::Duration into) const noexcept {
  const auto after =
      std::upper_bound(stretches_.begin(), stretches_.end(), into,
                       [](core::Duration t, const Stretch& stretch) { return t < stretch.begin; });
  if (after == stretches_.begin()) return nullptr;
  const Stretch& candidate = *std::prev(after);
  return into <= candidate.end ? &candidate : nullptr;
}

void Replay::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  reading.fresh = false;
  if (closed_) {
    reading.armed = false;
    reading.health = core::DeviceHealth::kLost;
    return;
  }
  arming_.on_read();
  reading.armed = arming_.armed();
  reading.health = core::DeviceHealth::kOk;
  if (!started_) {
    started_ = true;
    start_ = now;
  }
  if (now <= last_read_) return;
  last_read_ = now;

  core::Duration into = now - start_;
  if (repeat_) into %= facts_.length + kPause;
  const Stretch* stretch = stretch_at(into);
  if (stretch == nullptr) return;
  const double t = core::seconds(into);
  if (facts_.joint_angles) {
    core::VecX x(2);
    x << stretch->column[0](t), stretch->column[1](t);
    static_cast<void>(kinematics_->inverse(x, q_));
  } else {
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      q_[i] = stretch->column[static_cast<std::size_t>(i)](t);
    }
  }
  reading.fresh = true;
  reading.sample.seq = ++seq_;
  reading.sample.time = now;
  reading.sample.q = q_;
  reading.sample.tau_measured.resize(0);
}

void Replay::write(core::TimePoint, const Command& command) noexcept {
  arming_.on_write(command.arm && !closed_);
}

void Replay::close() noexcept {
  closed_ = true;
  arming_.disarm();
}

}  // namespace haptic::hw
