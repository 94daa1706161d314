#include "hw/replay/replay.hpp"

#include <algorithm>
#include <sstream>

#include "haptic/core/error.hpp"
#include "hw/device_limits.hpp"
#include "hw/replay/tracked_orientation.hpp"

namespace haptic::hw {
namespace {

ColumnSet dof_names(const core::Kinematics& kinematics) {
  ColumnSet names;
  for (const core::DofSpec& dof : kinematics.dofs()) names.push_back(dof.name);
  return names;
}

/// The joint angles of a map with an inverse in closed form, NAME_rad; empty without one.
ColumnSet joint_angles_of(const core::Kinematics& kinematics) {
  ColumnSet names;
  core::VecQ q = core::VecQ::Zero(kinematics.layout().n_q());
  const core::VecX x = core::VecX::Zero(kinematics.space().n_x());
  if (kinematics.inverse(x, q) == core::InverseStatus::kNotOffered) return names;
  for (const core::Coordinate& coordinate : kinematics.space().coordinates()) {
    names.push_back(coordinate.name + "_rad");
  }
  return names;
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

std::unique_ptr<Device> ReplayConfig::open(std::shared_ptr<const core::Kinematics> kinematics,
                                           core::Duration) const {
  return std::make_unique<Replay>(*this, std::move(kinematics));
}

Replay::Replay(const ReplayConfig& config, std::shared_ptr<const core::Kinematics> kinematics)
    : kinematics_(std::move(kinematics)), repeat_(config.repeat) {
  info_.limits = device_limits(*kinematics_, config.max_effort);
  info_.limits.max_silence = core::duration(kLongestStep);
  info_.limits.silence_policy = core::SilencePolicy::kRampOut;
  info_.kind = "replay";
  info_.dofs = kinematics_->dofs();
  info_.moves = false;

  std::vector<ColumnSet> alternatives{dof_names(*kinematics_)};
  const std::optional<std::size_t> rotation = rotation_vector_in(info_.dofs);
  if (rotation) {
    alternatives.push_back(with_quaternion(alternatives.front(), *rotation));
  } else if (const ColumnSet angles = joint_angles_of(*kinematics_); !angles.empty()) {
    alternatives.push_back(angles);
  }
  MotionTable table = read_motion_csv(config.file, alternatives);
  facts_.rows = table.time_s.size();
  facts_.length = core::duration(table.time_s.back());
  facts_.joint_angles = table.alternative == 1 && !rotation;
  if (facts_.joint_angles) {
    const Columns q = bring_into_reach(table);
    cut_at_gaps(table.time_s, q, table.values);
  } else {
    if (table.alternative == 1) {
      from_quaternions(table, *rotation, info_.dofs[*rotation].name, config.file);
    }
    turn_near(table.values, *kinematics_, Near::kZero);
    for (std::size_t c = 0; c < info_.dofs.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      require_range(table, c, info_.dofs[c], info_.limits.q_lower[i], info_.limits.q_upper[i],
                    config.file);
    }
    turn_near(table.values, *kinematics_, Near::kPreviousRow);
    cut_at_gaps(table.time_s, table.values, {});
  }
  info_.model = summary(config.file, facts_);
  info_.notes = table.doubts;
  if (2 * facts_.replaced > facts_.rows) {
    info_.notes.push_back(config.file.string() + ": " + std::to_string(facts_.replaced) + " of " +
                          std::to_string(facts_.rows) +
                          " rows are outside the device's reach: replaced by the nearest pose");
  }
  q_ = home_ = core::VecQ::Zero(kinematics_->layout().n_q());
}

/// Returns q of every row. Angles outside the reach are replaced by f(q).
Columns Replay::bring_into_reach(MotionTable& table) {
  const int n_q = kinematics_->layout().n_q();
  Columns columns(static_cast<std::size_t>(n_q), std::vector<double>(facts_.rows));
  core::VecQ q = core::VecQ::Zero(n_q);
  core::VecX x(kinematics_->space().n_x());
  core::VecX reached;
  core::MatXQ J;
  for (std::size_t row = 0; row < facts_.rows; ++row) {
    for (int i = 0; i < x.size(); ++i) x[i] = table.values[static_cast<std::size_t>(i)][row];
    const bool exact = kinematics_->inverse(x, q) == core::InverseStatus::kExact;
    for (int i = 0; i < n_q; ++i) columns[static_cast<std::size_t>(i)][row] = q[i];
    if (exact) continue;
    ++facts_.replaced;
    if (kinematics_->evaluate(q, reached, J) != core::MapStatus::kOk) continue;
    for (int i = 0; i < x.size(); ++i) table.values[static_cast<std::size_t>(i)][row] = reached[i];
  }
  return columns;
}

void Replay::cut_at_gaps(const std::vector<double>& time_s, const Columns& q, const Columns& x) {
  const auto part = [](const std::vector<double>& all, std::size_t begin, std::size_t end) {
    return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(begin),
                               all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  const auto parts = [&](const Columns& all, std::size_t begin, std::size_t end) {
    Columns columns;
    for (const auto& column : all) columns.push_back(part(column, begin, end));
    return columns;
  };
  std::size_t begin = 0;
  for (std::size_t row = 1; row <= time_s.size(); ++row) {
    const bool last = row == time_s.size();
    if (!last && !is_gap(time_s[row - 1], time_s[row])) continue;
    if (!last) ++facts_.gaps;
    const std::vector<double> time = part(time_s, begin, row);
    if (x.empty()) {
      stretches_.emplace_back(time, parts(q, begin, row));
    } else {
      stretches_.emplace_back(time, parts(q, begin, row), parts(x, begin, row), kinematics_);
    }
    begin = row;
  }
}

const Stretch* Replay::stretch_at(core::Duration into) const noexcept {
  const auto after = std::upper_bound(
      stretches_.begin(), stretches_.end(), into,
      [](core::Duration t, const Stretch& stretch) { return t < stretch.begin(); });
  if (after == stretches_.begin()) return nullptr;
  const Stretch& candidate = *std::prev(after);
  return into <= candidate.end() ? &candidate : nullptr;
}

void Replay::read(core::TimePoint now, core::DeviceReading& reading) noexcept {
  if (!book_.begin_read(now, reading)) return;
  if (!start_) start_ = now;
  core::Duration into = now - *start_;
  if (repeat_) into %= facts_.length + kPause;
  const Stretch* stretch = stretch_at(into);
  if (stretch == nullptr) return;
  stretch->at(core::seconds(into), q_);
  kinematics_->nearest_representative(home_, q_);
  book_.deliver(now, q_, reading);
}

void Replay::write(core::TimePoint, const Command& command) noexcept {
  static_cast<void>(book_.follows(command));
}

void Replay::close() noexcept {
  book_.close();
}

}  // namespace haptic::hw
