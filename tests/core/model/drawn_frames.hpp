#pragma once
/// Where the bodies of a drawing are: what a program that draws has to do, and all it may know.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "haptic/core/model/drawing.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

using DrawnFrame = Eigen::Isometry3d;

inline Eigen::Isometry3d moved(const DrawnMotion& motion, const DrawnFrame& so_far, const VecQ& q,
                               const VecX& x, const std::vector<DrawnFrame>& frames) {
  using Kind = DrawnMotion::Kind;
  const bool by_q = motion.value == DrawnValue::kQ;
  const auto value = [&](int i) { return by_q ? q[motion.index + i] : x[motion.index + i]; };
  Eigen::Isometry3d by = Eigen::Isometry3d::Identity();
  switch (motion.kind) {
    case Kind::kRotation:
      by.rotate(Eigen::AngleAxisd(motion.factor * value(0) + motion.offset, motion.axis));
      break;
    case Kind::kTranslation:
      by.translate((motion.factor * value(0) + motion.offset) * motion.axis);
      break;
    case Kind::kOrientation:
      by.rotate(Eigen::Quaterniond(value(3), value(0), value(1), value(2)).normalized());
      break;
    case Kind::kRotationVector: {
      const Eigen::Vector3d phi(value(0), value(1), value(2));
      if (phi.norm() > 0.0) by.rotate(Eigen::AngleAxisd(phi.norm(), phi.normalized()));
      break;
    }
    case Kind::kAim: {
      const auto target = static_cast<std::size_t>(motion.target);
      const Eigen::Vector3d p = so_far.inverse() * (frames.at(target) * motion.target_point);
      const double angle =
          std::atan2(p.y(), p.x()) - std::asin(motion.offset / std::hypot(p.x(), p.y()));
      by.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
      break;
    }
  }
  return by;
}

/// The frame of every body in the world.
inline std::vector<DrawnFrame> drawn_frames(const Drawing& drawing, const VecQ& q, const VecX& x) {
  std::vector<DrawnFrame> frames;
  for (const DrawnBody& body : drawing.bodies) {
    DrawnFrame frame = DrawnFrame::Identity();
    if (body.parent >= 0) frame = frames.at(static_cast<std::size_t>(body.parent));
    frame.translate(body.position).rotate(body.orientation);
    for (const DrawnMotion& motion : body.motions) {
      frame = frame * moved(motion, frame, q, x, frames);
    }
    frames.push_back(frame);
  }
  return frames;
}

/// Index of the body of that name and part.
inline std::size_t body_named(const Drawing& drawing, const std::string& name, DrawnPart part) {
  const auto at =
      std::find_if(drawing.bodies.begin(), drawing.bodies.end(),
                   [&](const DrawnBody& body) { return body.name == name && body.part == part; });
  EXPECT_NE(at, drawing.bodies.end()) << name;
  return static_cast<std::size_t>(at - drawing.bodies.begin());
}

}  // namespace haptic::core
