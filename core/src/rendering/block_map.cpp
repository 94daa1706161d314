#include "haptic/core/rendering/block_map.hpp"

#include <algorithm>
#include <cstring>

namespace haptic::core {

namespace {

/// Bits decide, so that a NaN is not new in every tick.
bool same_bits(const double* a, const double* b, int n) noexcept {
  return std::memcmp(a, b, sizeof(double) * static_cast<std::size_t>(n)) == 0;
}

/// Plane i curves among the coordinates [first, first + count).
bool curves(const PlaneSet& planes, int i, int first, int count) noexcept {
  const auto p = static_cast<std::size_t>(i);
  return planes.curved[p] > 0 && planes.first[p] < first + count &&
         first < planes.first[p] + planes.curved[p];
}

}  // namespace

BlockMap::BlockMap(const Kinematics& kinematics)
    : x_probe_(VecX::Zero(kinematics.space().n_x())),
      J_(MatXQ::Zero(kinematics.space().n_x(), kinematics.layout().n_q())) {
  for (const int first : kinematics.space().quaternions()) x_probe_[first + 3] = 1.0;  // no turn
  for (const MapBlock& at : blocks_or_whole(kinematics)) {
    Block block;
    block.at = at;
    block.n_q = at.n_q();
    block.n_x = at.n_x();
    block.q = VecQ::Zero(block.n_q);
    block.x = VecX::Zero(block.n_x);
    all_ |= BlockSet{1} << blocks_.size();
    blocks_.push_back(block);
  }
}

BlockSet BlockMap::move_to(const VecQ& q) noexcept {
  BlockSet failed = 0, bit = 1;
  for (Block& block : blocks_) {
    const double* at = q.data() + block.at.first_q;
    if (!block.known || !same_bits(at, block.q.data(), block.n_q)) {
      std::copy(at, at + block.n_q, block.q.data());
      block.known = true;
      evaluate(block);
      if (block.closes) std::copy_n(block.x.data(), block.n_x, x_probe_.data() + block.at.first_x);
    }
    if (!block.closes) failed |= bit;
    bit <<= 1;
  }
  return failed;
}

void BlockMap::differentiate(BlockSet needed) noexcept {
  for (Block& block : blocks_) {
    block.wants_J = (needed & 1u) != 0;
    needed >>= 1;
    if (block.wants_J && !block.has_J) evaluate(block);
  }
}

void BlockMap::evaluate(Block& block) noexcept {
  const Kinematics& kinematics = *block.at.kinematics;
  block.has_J = false;
  if (!block.wants_J) {
    block.closes = kinematics.position(block.q, block.x) == MapStatus::kOk;
    return;
  }
  block.closes = kinematics.evaluate(block.q, block.x, block_J_) == MapStatus::kOk;
  if (!block.closes) return;
  block.has_J = true;
  for (int k = 0; k < block.n_q; ++k) {
    const double* from = block_J_.data() + k * block.n_x;
    std::copy(from, from + block.n_x,
              J_.data() + (block.at.first_q + k) * J_.rows() + block.at.first_x);
  }
}

BlockSet BlockMap::displaced(const VecX& dx) const noexcept {
  BlockSet found = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double* first = dx.data() + blocks_[i].at.first_x;
    if (std::any_of(first, first + blocks_[i].n_x, [](double d) { return d != 0.0; })) {
      found |= BlockSet{1} << i;
    }
  }
  return found;
}

BlockSet BlockMap::reached(const PlaneSet& planes) const noexcept {
  const Eigen::Index n_x = planes.normals.rows();
  BlockSet found = 0, bit = 1;
  for (const Block& block : blocks_) {
    for (int i = 0; i < planes.size(); ++i) {
      const double* first = planes.normals.data() + i * n_x + block.at.first_x;
      if (std::any_of(first, first + block.n_x, [](double n) { return n != 0.0; }) ||
          curves(planes, i, block.at.first_x, block.n_x)) {
        found |= bit;
      }
    }
    bit <<= 1;
  }
  return found;
}

void BlockMap::copy_q(BlockSet blocks, const VecQ& from, VecQ& to) const noexcept {
  for (const Block& block : blocks_) {
    const int first = block.at.first_q;
    if ((blocks & 1u) != 0) std::copy_n(from.data() + first, block.n_q, to.data() + first);
    blocks >>= 1;
  }
}

void BlockMap::copy_x(BlockSet blocks, const VecX& from, VecX& to) const noexcept {
  for (const Block& block : blocks_) {
    const int first = block.at.first_x;
    if ((blocks & 1u) != 0) std::copy_n(from.data() + first, block.n_x, to.data() + first);
    blocks >>= 1;
  }
}

void BlockMap::clear_x(BlockSet blocks, VecX& x) const noexcept {
  for (const Block& block : blocks_) {
    if ((blocks & 1u) != 0) std::fill_n(x.data() + block.at.first_x, block.n_x, 0.0);
    blocks >>= 1;
  }
}

}  // namespace haptic::core
