#include "haptic/core/projection/block_map.hpp"

#include <algorithm>
#include <cstring>

namespace haptic::core {

namespace {

/// Bits decide, so that a NaN is not new in every tick.
bool same_bits(const double* a, const double* b, int n) noexcept {
  return std::memcmp(a, b, sizeof(double) * static_cast<std::size_t>(n)) == 0;
}

}  // namespace

BlockMap::BlockMap(const Kinematics& kinematics)
    : x_probe_(VecX::Zero(kinematics.space().n_x())),
      J_(MatXQ::Zero(kinematics.space().n_x(), kinematics.layout().n_q())) {
  const MapBlock whole[] = {{&kinematics, 0, 0, 0}};
  const std::span<const MapBlock> blocks =
      kinematics.blocks().empty() ? std::span<const MapBlock>(whole) : kinematics.blocks();
  for (const MapBlock& block : blocks) {
    Part part;
    part.at = block;
    part.n_q = block.kinematics->layout().n_q();
    part.n_x = block.kinematics->space().n_x();
    part.q = VecQ::Zero(part.n_q);
    part.x = VecX::Zero(part.n_x);
    all_ |= BlockSet{1} << parts_.size();
    parts_.push_back(part);
  }
}

BlockSet BlockMap::move_to(const VecQ& q) noexcept {
  BlockSet failed = 0, bit = 1;
  for (Part& part : parts_) {
    const double* at = q.data() + part.at.first_q;
    if (!part.known || !same_bits(at, part.q.data(), part.n_q)) {
      std::copy(at, at + part.n_q, part.q.data());
      part.known = true;
      evaluate(part);
      if (part.closes) std::copy_n(part.x.data(), part.n_x, x_probe_.data() + part.at.first_x);
    }
    if (!part.closes) failed |= bit;
    bit <<= 1;
  }
  return failed;
}

void BlockMap::differentiate(BlockSet needed) noexcept {
  for (Part& part : parts_) {
    part.wants_J = (needed & 1u) != 0;
    needed >>= 1;
    if (part.wants_J && !part.has_J) evaluate(part);
  }
}

void BlockMap::evaluate(Part& part) noexcept {
  const Kinematics& kinematics = *part.at.kinematics;
  part.has_J = false;
  if (!part.wants_J) {
    part.closes = kinematics.position(part.q, part.x) == MapStatus::kOk;
    return;
  }
  part.closes = kinematics.evaluate(part.q, part.x, block_) == MapStatus::kOk;
  if (!part.closes) return;
  part.has_J = true;
  for (int k = 0; k < part.n_q; ++k) {
    const double* from = block_.data() + k * part.n_x;
    std::copy(from, from + part.n_x,
              J_.data() + (part.at.first_q + k) * J_.rows() + part.at.first_x);
  }
}

BlockSet BlockMap::displaced(const VecX& dx) const noexcept {
  BlockSet found = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const double* first = dx.data() + parts_[i].at.first_x;
    if (std::any_of(first, first + parts_[i].n_x, [](double d) { return d != 0.0; })) {
      found |= BlockSet{1} << i;
    }
  }
  return found;
}

BlockSet BlockMap::reached(const PlaneSet& planes) const noexcept {
  const Eigen::Index n_x = planes.normals.rows();
  BlockSet found = 0, bit = 1;
  for (const Part& part : parts_) {
    for (int i = 0; i < planes.size(); ++i) {
      const double* first = planes.normals.data() + i * n_x + part.at.first_x;
      if (std::any_of(first, first + part.n_x, [](double n) { return n != 0.0; })) found |= bit;
    }
    bit <<= 1;
  }
  return found;
}

void BlockMap::copy_q(BlockSet blocks, const VecQ& from, VecQ& to) const noexcept {
  for (const Part& part : parts_) {
    const int first = part.at.first_q;
    if ((blocks & 1u) != 0) std::copy_n(from.data() + first, part.n_q, to.data() + first);
    blocks >>= 1;
  }
}

void BlockMap::copy_x(BlockSet blocks, const VecX& from, VecX& to) const noexcept {
  for (const Part& part : parts_) {
    const int first = part.at.first_x;
    if ((blocks & 1u) != 0) std::copy_n(from.data() + first, part.n_x, to.data() + first);
    blocks >>= 1;
  }
}

void BlockMap::clear_x(BlockSet blocks, VecX& x) const noexcept {
  for (const Part& part : parts_) {
    if ((blocks & 1u) != 0) std::fill_n(x.data() + part.at.first_x, part.n_x, 0.0);
    blocks >>= 1;
  }
}

}  // namespace haptic::core
