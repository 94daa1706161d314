#pragma once
/// Fuzzed interfaces: the serial link, the datagram path, what a front sends to the owner, the
/// scene loader and replayed files. A target takes any bytes and says what is wrong; empty:
/// nothing. libFuzzer drives it (run.sh), and so do the tests, with a fixed count (fuzz_test.cpp).

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace haptic::test {

using FuzzInput = std::span<const std::uint8_t>;
using FuzzBytes = std::vector<std::uint8_t>;

struct FuzzTarget {
  const char* name;
  std::string (*run)(FuzzInput input);
  /// Inputs that go deep, for the corpus to begin with.
  std::vector<FuzzBytes> (*seeds)();
  std::size_t longest;  ///< of an input, bytes
};

/// wire::PathEnd of a server, and the message behind it: datagrams as they come, and payloads
/// sealed with the right keys. Findings: a rejected datagram says or sends something, a message or
/// an answer is longer than it may be, more is answered than asked.
[[nodiscard]] const FuzzTarget& datagram_target();
/// Data that the owner reads from a front: its pages, written in any way at any time, and its
/// messages; behind them requests, leases and the ingress. Findings: what the loop or a front would
/// get is not finite, too large, of a wrong size, unknown, out of order or from the future; more is
/// read or kept than is allowed; an honest client that comes afterwards gets no lease, or no sample
/// through.
[[nodiscard]] const FuzzTarget& crossing_target();
/// server::parse_scene. Findings: an error without a word, another exception than SceneError, a
/// scene that does not read back as itself.
[[nodiscard]] const FuzzTarget& scene_target();

/// The serial link's codec, and the readers of every message. Findings: an undamaged frame is not
/// read, or one is that was not written.
[[nodiscard]] const FuzzTarget& frame_target();
/// hw::Replay. Findings: an error without a word, another exception than DeviceError, a sample that
/// is no number, of a wrong size or out of the device's range.
[[nodiscard]] const FuzzTarget& replay_target();

/// Numbers out of an input, 0 beyond its end.
class FuzzReader {
 public:
  explicit FuzzReader(FuzzInput input) : rest_(input) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::uint8_t byte();
  std::uint64_t number(int bytes);
  FuzzInput take(std::size_t size);

 private:
  FuzzInput rest_;
};

}  // namespace haptic::test
