#include "hw/simulated/hand_intent.hpp"

#include <algorithm>
#include <utility>

#include "hw/motion/motion_csv.hpp"
#include "hw/replay/tracked_orientation.hpp"

namespace haptic::hw {
namespace {

constexpr Eigen::Index kRotation = 3;  // of a palm's DoFs: the first of its rotation vector

/// Columns that stand in a file together or not at all, for the coordinates from `first` on.
struct Group {
  Eigen::Index first{0};
  ColumnSet columns{};
};

bool any_in(const ColumnSet& header, const ColumnSet& columns) {
  return std::find_first_of(header.begin(), header.end(), columns.begin(), columns.end()) !=
         header.end();
}

std::vector<Group> groups_of(const HandLayout& layout, const core::Kinematics& kinematics,
                             const ColumnSet& header) {
  std::vector<Group> groups;
  if (layout.palm) {
    const auto palm = static_cast<std::size_t>(*layout.palm);
    ColumnSet names;
    for (std::size_t i = palm; i < palm + 6; ++i) names.push_back(kinematics.dofs()[i].name);
    const ColumnSet turned = with_quaternion(names, kRotation);
    const bool quaternion = any_in(header, {turned.begin() + kRotation, turned.end()});
    const ColumnSet& pose = quaternion ? turned : names;
    groups.push_back({*layout.palm, {pose.begin(), pose.begin() + kRotation}});
    groups.push_back({*layout.palm + kRotation, {pose.begin() + kRotation, pose.end()}});
  }
  for (const HandLayout::Finger& finger : layout.fingers) {
    Group group{finger.first};
    for (const std::string& angle : joint_angle_columns()) {
      group.columns.push_back(finger.prefix + angle);
    }
    groups.push_back(group);
  }
  return groups;
}

/// The target, but its fingers straight.
core::VecQ straight(const HandLayout& layout, core::VecQ target) {
  for (const HandLayout::Finger& finger : layout.fingers) {
    target.segment<2>(finger.first).setZero();
  }
  return target;
}

}  // namespace

HandIntent::HandIntent(const core::VecQ& rest, const core::VecQ& target) {
  for (Eigen::Index i = 0; i < target.size(); ++i) course_.emplace_back(rest[i], target[i]);
}

HandIntent::HandIntent(const HandLayout& layout, const core::VecQ& target)
    : HandIntent(straight(layout, target), target) {}

HandIntent::HandIntent(const HandLayout& layout, const core::VecQ& target,
                       const core::Kinematics& kinematics, const std::filesystem::path& motion_file)
    : HandIntent(layout, target) {
  const ColumnSet header = motion_columns(motion_file);
  std::vector<Group> groups = groups_of(layout, kinematics, header);
  const auto absent = [&](const Group& group) { return !any_in(header, group.columns); };
  if (!std::all_of(groups.begin(), groups.end(), absent)) std::erase_if(groups, absent);
  ColumnSet columns;
  for (const Group& group : groups) {
    columns.insert(columns.end(), group.columns.begin(), group.columns.end());
  }
  MotionTable table = read_motion_csv(motion_file, {columns});
  doubts_ = std::move(table.doubts);

  // The rows of all coordinates in the order of q; what has no columns keeps its course.
  Columns rows(course_.size(), std::vector<double>(table.time_s.size(), 0.0));
  std::vector<Eigen::Index> moved;
  std::size_t column = 0;
  for (const Group& group : groups) {
    const std::string& name = kinematics.dofs()[static_cast<std::size_t>(group.first)].name;
    if (group.columns.size() == 4) from_quaternions(table, column, name, motion_file);
    const Eigen::Index last = group.first + (group.columns.size() == 2 ? 2 : 3);
    for (Eigen::Index i = group.first; i < last; ++i, ++column) {
      const core::DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(i)];
      if (layout.palm == group.first) {
        require_range(table, column, dof, dof.lower, dof.upper, motion_file);
      }
      rows[static_cast<std::size_t>(i)] = table.values[column];
      moved.push_back(i);
    }
    recorded_fingers_ += group.columns.size() == 2 ? 1 : 0;
  }
  turn_near(rows, kinematics, Near::kPreviousRow);
  for (const Eigen::Index i : moved) {
    Pchip motion(table.time_s, rows[static_cast<std::size_t>(i)]);
    const bool of_palm = layout.palm && i >= *layout.palm && i < *layout.palm + 6;
    const double rest = of_palm ? motion(0.0) : 0.0;
    course_[static_cast<std::size_t>(i)] = Course(rest, std::move(motion));
    recorded_ = static_cast<std::size_t>(i);
  }
}

core::VecQ HandIntent::at(double t) const noexcept {
  const Course::Moment now = course_[recorded_].moment(t);
  core::VecQ aim(static_cast<Eigen::Index>(course_.size()));
  for (Eigen::Index i = 0; i < aim.size(); ++i)
    aim[i] = course_[static_cast<std::size_t>(i)].at(now);
  return aim;
}

}  // namespace haptic::hw
