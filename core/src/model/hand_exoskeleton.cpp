#include "haptic/core/model/hand_exoskeleton.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drawing_parts.hpp"
#include "haptic/core/error.hpp"
#include "tree_map.hpp"

namespace haptic::core {

namespace {

/// A finger of a hand: its own map, and its DoFs under its name.
struct FingerBlock {
  std::string name{};
  std::shared_ptr<const Kinematics> kinematics{};
};

/// Throws SceneError naming the finger: a name empty or among `others`, dimensions that cannot be.
FingerBlock finger_block(const HandFinger& finger, const std::vector<FingerBlock>& others) {
  if (finger.name.empty()) throw SceneError("a finger's name is empty: must be given");
  for (const FingerBlock& other : others) {
    if (other.name == finger.name) {
      throw SceneError("finger " + finger.name + " given twice: names must differ");
    }
  }
  try {
    return {finger.name, make_finger_exoskeleton(finger.dimensions)};
  } catch (const SceneError& error) {
    throw SceneError("finger " + finger.name + ": " + error.what());
  }
}

/// NAME.l_x and NAME.q_B.
void append_finger(const FingerBlock& finger, std::vector<DofSpec>& dofs) {
  for (DofSpec dof : finger.kinematics->dofs()) {
    dof.name = finger.name + "." + dof.name;
    dofs.push_back(std::move(dof));
  }
}

constexpr int kPerFinger = 2;  // DoFs, and coordinates

/// From finger to finger of a hand without a palm, in its drawing only, m: a knuckle's breadth.
constexpr double kAcross = 0.022;

std::vector<DofSpec> dofs_of(const std::vector<FingerBlock>& fingers) {
  std::vector<DofSpec> all;
  for (const FingerBlock& finger : fingers) append_finger(finger, all);
  return all;
}

std::vector<Coordinate> coordinates_of(const std::vector<FingerBlock>& fingers) {
  std::vector<Coordinate> all;
  for (const FingerBlock& finger : fingers) {
    for (Coordinate coordinate : finger.kinematics->space().coordinates()) {
      coordinate.name = finger.name + "." + coordinate.name;
      all.push_back(std::move(coordinate));
    }
  }
  return all;
}

class HandExoskeleton final : public Kinematics {
 public:
  explicit HandExoskeleton(std::vector<FingerBlock> fingers)
      : Kinematics(dofs_of(fingers), ConfigurationSpace(coordinates_of(fingers))),
        fingers_(std::move(fingers)) {
    double squares = 0.0;
    for (const FingerBlock& finger : fingers_) {
      const int i = static_cast<int>(blocks_.size());
      blocks_.push_back({finger.kinematics.get(), kPerFinger * i, i, kPerFinger * i});
      const double mean = finger.kinematics->mean_actuated_jacobian();
      squares += mean * mean;
      mechanisms_.push_back({finger.kinematics.get(), kPerFinger * i});
    }
    mean_J_a_ = std::sqrt(squares);
  }

  std::span<const MapBlock> blocks() const noexcept override { return blocks_; }

  MapStatus evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept override {
    if (q.size() != layout_.n_q()) return MapStatus::kCannotClose;
    double x[kMaxQ];
    Eigen::Matrix<double, kPerFinger, kPerFinger> J_of[kMaxQ / kPerFinger];
    VecX part;
    MatXQ block;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const int at = blocks_[i].first_q;
      const VecQ q_of = q.segment<kPerFinger>(at);
      if (blocks_[i].kinematics->evaluate(q_of, part, block) != MapStatus::kOk) {
        return MapStatus::kCannotClose;
      }
      std::copy(part.data(), part.data() + kPerFinger, x + at);
      J_of[i] = block;
    }
    x_probe.resize(layout_.n_q());
    std::copy(x, x + x_probe.size(), x_probe.data());
    J.setZero(layout_.n_q(), layout_.n_q());
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const int at = blocks_[i].first_q;
      J.block<kPerFinger, kPerFinger>(at, at) = J_of[i];
    }
    return MapStatus::kOk;
  }

  std::span<const Mechanism> mechanisms() const noexcept override { return mechanisms_; }

  InverseStatus inverse(const VecX& x, VecQ& q) const noexcept override {
    q.resize(layout_.n_q());
    InverseStatus worst = InverseStatus::kExact;
    VecQ part;
    for (const MapBlock& finger : blocks_) {
      const int at = finger.first_q;
      const auto status = finger.kinematics->inverse(x.segment<kPerFinger>(at), part);
      q.segment<kPerFinger>(at) = part;
      worst = std::max(worst, status);
    }
    return worst;
  }

  Drawing drawing() const override {
    Drawing drawing;
    const double middle = 0.5 * static_cast<double>(fingers_.size() - 1);
    for (std::size_t i = 0; i < fingers_.size(); ++i) {
      append(fingers_[i].kinematics->drawing(),
             {.prefix = fingers_[i].name + ".",
              .position = {0.0, 0.0, kAcross * (static_cast<double>(i) - middle)},
              .first_q = blocks_[i].first_q,
              .first_a = blocks_[i].first_a,
              .first_x = blocks_[i].first_x},
             drawing);
    }
    return drawing;
  }

 private:
  std::vector<FingerBlock> fingers_;
  std::vector<MapBlock> blocks_{};
  std::vector<Mechanism> mechanisms_{};
};

/// Bodies of the tree: the palm, then proximal and middle phalanx of each finger.
constexpr int kPalm = 0;

int body(std::size_t finger, Phalanx phalanx) noexcept {
  return 1 + 2 * static_cast<int>(finger) + (phalanx == Phalanx::kMiddle ? 1 : 0);
}

/// Flexion turns a phalanx from dorsal to palmar, from +y to -y: about -z.
const Eigen::Vector3d kFlexion = -Eigen::Vector3d::UnitZ();

void append_phalanges(const MountedFinger& mounted, std::vector<TreeJoint>& joints) {
  const Pose3& mount = mounted.mount;
  require_pose(mount, "finger " + mounted.finger.name + ".mount");
  const int proximal = static_cast<int>(joints.size());
  joints.push_back({TreeJoint::Motion::kRevolute, kPalm, quaternion(mount.orientation),
                    vector(mount.position), kFlexion});
  const Eigen::Vector3d pip(mounted.finger.dimensions.proximal_phalanx, 0.0, 0.0);
  joints.push_back(
      {TreeJoint::Motion::kRevolute, proximal, Eigen::Quaterniond::Identity(), pip, kFlexion});
}

TreeOutput tree_output(const PhalanxOutput& output, const std::vector<FingerBlock>& fingers,
                       const std::vector<TreeOutput>& others) {
  const std::string where = "output " + output.name;
  require_new_output(output.name, output.offset, others);
  int on = kPalm;
  if (!output.finger.empty()) {
    const auto at = std::find_if(fingers.begin(), fingers.end(), [&](const FingerBlock& finger) {
      return finger.name == output.finger;
    });
    if (at == fingers.end()) {
      throw SceneError(where + ".finger = " + output.finger + ": must be one of the hand's");
    }
    on = body(static_cast<std::size_t>(at - fingers.begin()), output.phalanx);
  }
  return {output.name, on, output.kind, vector(output.offset.position),
          quaternion(output.offset.orientation)};
}

}  // namespace

std::unique_ptr<Kinematics> make_hand_exoskeleton(const std::vector<HandFinger>& fingers) {
  if (fingers.empty() || fingers.size() > static_cast<std::size_t>(kMaxQ / kPerFinger)) {
    throw SceneError("hand with " + std::to_string(fingers.size()) + " fingers: must have 1 to " +
                     std::to_string(kMaxQ / kPerFinger));
  }
  std::vector<FingerBlock> blocks;
  blocks.reserve(fingers.size());
  for (const HandFinger& finger : fingers) blocks.push_back(finger_block(finger, blocks));
  return std::make_unique<HandExoskeleton>(std::move(blocks));
}

std::unique_ptr<Kinematics> make_tracked_hand(const TrackedHandParameters& parameters) {
  const std::size_t n_q = 6 + 2 * parameters.fingers.size();
  if (parameters.fingers.empty() || n_q > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("tracked hand with " + std::to_string(parameters.fingers.size()) +
                     " fingers: must have 1 to " + std::to_string((kMaxQ - 6) / 2));
  }
  std::vector<DofSpec> dofs;
  append_palm(parameters.palm, dofs);
  std::vector<TreeJoint> joints{{TreeJoint::Motion::kFree}};
  std::vector<FingerBlock> fingers;
  std::vector<TreeDrive> drives;
  for (const MountedFinger& mounted : parameters.fingers) {
    fingers.push_back(finger_block(mounted.finger, fingers));
    drives.push_back({static_cast<int>(dofs.size()), fingers.back().kinematics});
    append_finger(fingers.back(), dofs);
    append_phalanges(mounted, joints);
  }
  std::vector<TreeOutput> outputs;
  for (const PhalanxOutput& output : parameters.outputs) {
    outputs.push_back(tree_output(output, fingers, outputs));
  }
  constexpr int kRotation = 3;
  return std::make_unique<TreeMap>(RigidTree(std::move(joints), std::move(outputs)),
                                   std::move(dofs), std::move(drives), kRotation);
}

}  // namespace haptic::core
