#include "haptic/core/model/hand_exoskeleton.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "finger_block.hpp"
#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

constexpr int kPerFinger = 2;  // DoFs, and coordinates

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
      pairs_.push_back(kPerFinger * i);
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

  MapStatus second_order(const VecQ& q, int k, MatXQ& J_k) const noexcept override {
    const int at = k - k % kPerFinger;
    MatXQ block;
    const Kinematics& finger = *fingers_[static_cast<std::size_t>(k / kPerFinger)].kinematics;
    if (finger.second_order(q.segment<kPerFinger>(at), k - at, block) != MapStatus::kOk) {
      return MapStatus::kCannotClose;
    }
    J_k.setZero(layout_.n_q(), layout_.n_q());
    J_k.block<kPerFinger, kPerFinger>(at, at) = block;
    return MapStatus::kOk;
  }

  std::span<const int> limited_pairs() const noexcept override { return pairs_; }
  MapStatus pair_limits(int which, double a, double b, PairLimits& limits) const noexcept override {
    return blocks_[static_cast<std::size_t>(which)].kinematics->pair_limits(0, a, b, limits);
  }

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

 private:
  std::vector<FingerBlock> fingers_;
  std::vector<MapBlock> blocks_{};
  std::vector<int> pairs_{};
};

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

}  // namespace haptic::core
