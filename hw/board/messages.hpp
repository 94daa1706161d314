#pragma once
/// Payloads of the frames of hw/README.md#the-board-protocol. write() and read() are inverse.
/// read() refuses a wrong length, a count that does not fit and a number that is not finite, so
/// that a message may be used without further checks. Only q of a State may be NaN: the loop must
/// see it, because it is a fault of a sensor.
///
/// State, Command and Counters allocate nothing; Identity and Dof are read at the handshake only.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "haptic/core/types.hpp"
#include "hw/board/frame_codec.hpp"

namespace haptic::hw::board {

inline constexpr std::uint8_t kProtocolVersion = 1;
inline constexpr std::size_t kMaxDofs = core::kMaxQ;
inline constexpr std::size_t kSerialWidth = 16, kModelWidth = 24, kNameWidth = 16;

using Values = std::array<float, kMaxDofs>;

/// Host: "who is there?" A session number other than the last one starts a new session.
struct Hello {
  std::uint8_t version{kProtocolVersion};
  std::uint32_t session{0};  ///< random, not 0
};

/// Host: follow commands that carry this nonce.
struct Arm {
  std::uint32_t nonce{0};  ///< not 0, another one than the last
};

/// Host: zero force, stop following.
struct Disarm {};

enum class CommandKind : std::uint8_t {
  kForce = 0,     ///< N or N m per actuated DoF
  kPosition = 1,  ///< m or rad per actuated DoF: boards that hold a position
};

struct Command {
  std::uint32_t nonce{0};  ///< that of the arming it belongs to
  CommandKind kind{CommandKind::kForce};
  std::uint8_t n_a{0};
  Values value{};
};

/// Abilities of a board, as bits.
enum Capability : std::uint8_t {
  kForceLoop = 1,        ///< closes the loop on the measured force itself
  kMeasuresForce = 2,    ///< State carries a force per actuated DoF
  kPositionCommand = 4,  ///< follows kPosition
};

/// Board: the answer to Hello, followed by one Dof per DoF.
struct Identity {
  std::uint8_t version{kProtocolVersion};
  std::uint8_t n_q{0}, n_a{0};
  std::uint8_t capabilities{0};
  std::uint32_t session{0};  ///< of the Hello it answers
  std::uint32_t watchdog_us{0};
  std::uint32_t sample_period_us{0};
  std::array<std::uint8_t, 3> firmware{};  ///< major, minor, patch
  std::string serial{}, model{};
};

struct Dof {
  std::uint8_t index{0};
  bool radian{false};  ///< units of this entry: rad and N m, or m and N
  bool actuated{false};
  float lower{0.0F}, upper{0.0F};
  float max_effort{0.0F}, max_rate{0.0F};  ///< of actuated DoFs; N, m/s
  std::string name{};
};

enum class BoardState : std::uint8_t { kDisarmed = 0, kArmed = 1, kStopped = 2, kFault = 3 };

/// Why a board is in kFault, as bits.
enum BoardFault : std::uint8_t {
  kForceOverLimit = 1,
  kSensorStuck = 2,  ///< a sensor has given the very same reading for too long
  kSensorRange = 4,  ///< a sensor reads what it cannot: broken wire, shorted
  kActuator = 8,     ///< over-current, over-temperature, no motion although there must be one
  kSupply = 16,      ///< under-voltage
};

/// Board: one sample, unasked, once a sample period.
struct State {
  std::uint64_t time_us{0};         ///< board's clock when q was measured
  std::uint32_t nonce{0};           ///< armed by; 0: not armed
  std::uint32_t command_seq{0};     ///< seq of the newest accepted Command; 0: none yet
  std::uint16_t command_age_us{0};  ///< its age at time_us; 65535: that or more
  BoardState state{BoardState::kDisarmed};
  std::uint8_t faults{0};  ///< BoardFault
  std::uint8_t n_q{0};
  std::uint8_t n_f{0};  ///< n_a if the board measures force, else 0
  Values q{};
  Values force{};  ///< n_f values; N or N m
};

/// Board, every 100 ms: frames accepted and dropped since its start. All wrap at 2^32.
struct Counters {
  std::uint32_t accepted{0}, bad_crc{0}, malformed{0}, not_newer{0}, wrong_nonce{0};
  std::uint32_t watchdog_stops{0}, states_dropped{0}, sessions{0};
};

struct Payload {
  std::array<std::uint8_t, kMaxPayload> bytes{};
  std::size_t length{0};
  [[nodiscard]] std::span<const std::uint8_t> view() const noexcept {
    return {bytes.data(), length};
  }
};

/// `Message` is one of the above. read() answers nothing if the payload is not such a message.
template <typename Message>
[[nodiscard]] Payload write(Message message) noexcept;
template <typename Message>
[[nodiscard]] std::optional<Message> read(std::span<const std::uint8_t> payload);

}  // namespace haptic::hw::board
