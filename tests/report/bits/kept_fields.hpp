#pragma once
/// Fields on which two builds of the core must agree in every tick, to the bit, and their hash.
///
/// Left out on purpose: anything that limits nothing and on which nothing acts, such as the
/// certificate of Eq. (8), so that it can go without a change of the force.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptic/core/tick/tick_record.hpp"

namespace haptic::report {

/// The values of one field of a tick as 64-bit words, a double by its bits.
using Words = std::vector<std::uint64_t>;

struct KeptField {
  const char* name;
  /// True: it decides what the device is sent.
  bool force;
  void (*write)(const core::TickRecord& record, Words& words);
};

/// In the order in which a tick makes them, so that the first one that differs is the cause.
[[nodiscard]] std::span<const KeptField> kept_fields();

/// A hash of a sequence of words; another order is another hash.
class Chain {
 public:
  void add(const Words& words) noexcept;
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_{0x9E3779B97F4A7C15U};
};

/// The hashes of one run.
class RunHashes {
 public:
  /// Ticks per block.
  static constexpr int kBlock = 100;

  RunHashes();
  void add(const core::TickRecord& record);

  /// Hashes of the fields that decide the force, from the first tick to the end of each block.
  [[nodiscard]] const std::vector<std::uint64_t>& blocks() const noexcept { return blocks_; }
  /// Hash of one of kept_fields(), from the first tick on.
  [[nodiscard]] std::uint64_t field(std::size_t i) const noexcept { return fields_[i].value(); }

 private:
  Chain force_{};
  std::vector<Chain> fields_;
  std::vector<std::uint64_t> blocks_{};
  Words words_{};
  int ticks_{0};
};

}  // namespace haptic::report
