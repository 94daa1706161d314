#pragma once
/// The error bound against the truth (core/METHOD.md#error-bound): random bodies that a client
/// tells as contacts from behind a network, in virtual time, by the shipped pipeline and the
/// shipped client library's contacts. The truth is the minimum for the bodies themselves, at the
/// probe that was felt, found by other means.

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace haptic::report {

enum class BoundKind : std::uint8_t {
  kDisc,     ///< one, a point in the plane
  kDiscs,    ///< two to four, which may overlap
  kFlat,     ///< one to three walls, of which some move
  kMoving,   ///< one to three discs that move, straight on
  kPads,     ///< three pads of a finger exoskeleton on a disc
  kStroked,  ///< the same, on a disc that moves
};
inline constexpr std::array kBoundKinds{BoundKind::kDisc,   BoundKind::kDiscs, BoundKind::kFlat,
                                        BoundKind::kMoving, BoundKind::kPads,  BoundKind::kStroked};
[[nodiscard]] std::string_view name(BoundKind kind) noexcept;
/// Its discs do.
[[nodiscard]] constexpr bool moves(BoundKind kind) noexcept {
  return kind == BoundKind::kMoving || kind == BoundKind::kStroked;
}

struct BoundRuns {
  long runs{0}, broken_runs{0};
  long ticks{0}, known{0}, broken{0};  ///< in contact, with a bound, and with one that is too small
  double worst{0.0};                   ///< of error less bound, N
  std::uint64_t worst_run{0};
  std::vector<double> errors{}, bounds{};  ///< of every fifth tick in contact with a bound, N

  void add(const BoundRuns& other);
};

/// One run: device, objects, motion, network and renderer by its number.
[[nodiscard]] BoundRuns bound_run(BoundKind kind, std::uint64_t number);

}  // namespace haptic::report
