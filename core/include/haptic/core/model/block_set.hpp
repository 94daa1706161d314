#pragma once
/// Which of a map's independent blocks (Kinematics::blocks(), the fingers of a hand).

#include <cstdint>

namespace haptic::core {

/// Bit i stands for the i-th of Kinematics::blocks(). A map without blocks counts as one block.
using BlockSet = std::uint32_t;

}  // namespace haptic::core
