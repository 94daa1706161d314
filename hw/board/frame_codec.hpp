#pragma once
/// Frames on the serial link to a board, both ways: hw/README.md#frames.
///
///   00 | COBS( type 1 | seq 4 | payload 0..240 | CRC-32C 4 ) | 00        little-endian
///
/// A zero byte stands only between frames, so a reader that lost its place finds it again at the
/// next zero. Each frame has a zero at both ends, so that damage to one zero spoils one frame only.
/// The body is at most 249 bytes, so COBS adds exactly one byte.
/// Source of COBS: S. Cheshire, M. Baker, IEEE/ACM Trans. Networking 7(2):159-172, 1999.
/// Nothing here allocates, throws or reads a clock.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptic::hw::board {

inline constexpr std::size_t kMaxPayload = 240;
inline constexpr std::size_t kFrameOverhead = 9;                       ///< type, seq, CRC
inline constexpr std::size_t kMaxBody = kMaxPayload + kFrameOverhead;  ///< before COBS
inline constexpr std::size_t kMaxWire = kMaxBody + 3;                  ///< one code, two zeros

/// Type of a frame: below 0x80 from the host, from 0x80 on from the board.
enum class FrameType : std::uint8_t {
  kHello = 0x01,
  kArm = 0x02,
  kDisarm = 0x03,
  kCommand = 0x04,
  kIdentity = 0x81,
  kDof = 0x82,
  kState = 0x83,
  kCounters = 0x84,
};

struct Frame {
  FrameType type{};  ///< may be any byte: the reader of the frame drops unknown types
  std::uint32_t seq{0};
  std::span<const std::uint8_t> payload{};
};

/// CRC-32C (Castagnoli), as in iSCSI: polynomial 0x1EDC6F41 reflected, start and final value all
/// ones. Source: RFC 3720, appendix B.4; check value of "123456789": E3069283.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes) noexcept;

using WireBuffer = std::array<std::uint8_t, kMaxWire>;

/// Writes the frame with both its zeros. Returns its length; 0 if the payload is too long.
[[nodiscard]] std::size_t encode(const Frame& frame, WireBuffer& wire) noexcept;

/// Finds the frames in a stream of bytes that may be damaged.
class FrameDecoder {
 public:
  enum class Event : std::uint8_t {
    kNone,       ///< nothing ended with this byte
    kFrame,      ///< frame() is whole and its CRC is right
    kMalformed,  ///< no COBS, too short or too long to be a frame
    kBadCrc,
  };

  [[nodiscard]] Event push(std::uint8_t byte) noexcept;
  /// The frame of the last kFrame; its payload stays until the next push().
  [[nodiscard]] const Frame& frame() const noexcept { return frame_; }
  /// Drops a partly read frame, because the link was opened again.
  void reset() noexcept { length_ = 0; }

 private:
  [[nodiscard]] Event finish() noexcept;

  std::array<std::uint8_t, kMaxBody + 1> chunk_{};  ///< between two zeros
  std::size_t length_{0};                           ///< larger than chunk_: the frame is too long
  Frame frame_{};
};

/// Sequence numbers rise by one per frame and wrap (RFC 1982). A number that is not ahead of the
/// last accepted one belongs to a frame that was repeated or came too late.
class SequenceFilter {
 public:
  /// Restarts at `seq`, which counts as accepted.
  void restart(std::uint32_t seq) noexcept { last_ = seq; }
  /// True if `seq` is newer. Adds the skipped numbers to lost().
  [[nodiscard]] bool accept(std::uint32_t seq) noexcept {
    const std::uint32_t ahead = seq - last_;
    if (ahead == 0 || ahead >= 0x80000000U) return false;
    lost_ += ahead - 1;
    last_ = seq;
    return true;
  }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  std::uint32_t last_{0};
  std::uint64_t lost_{0};
};

}  // namespace haptic::hw::board
