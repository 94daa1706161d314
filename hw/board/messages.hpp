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
#include <span>
#include <string>

#include "haptic/core/types.hpp"
#include "hw/firmware/haptic_board.h"

namespace haptic::hw::board {

inline constexpr std::size_t kMaxDofs = core::kMaxQ;
static_assert(kMaxDofs == HB_MAX_DOFS);
inline constexpr std::size_t kSerialWidth = 16, kModelWidth = 24, kNameWidth = 16;

using Values = std::array<float, kMaxDofs>;

/// Host: "who is there?" A session number other than the last one starts a new session.
struct Hello {
  std::uint8_t version{HB_PROTOCOL_VERSION};
  std::uint32_t session{0};  ///< random, not 0
};

/// Host: follow commands that carry this nonce.
struct Arm {
  std::uint32_t nonce{0};  ///< not 0, another one than the last
};

/// Host: zero force, stop following.
struct Disarm {};

struct Command {
  std::uint32_t nonce{0};       ///< that of the arming it belongs to
  std::uint8_t kind{HB_FORCE};  ///< hb_kind: N or N m per actuated DoF; m or rad, of a position
  std::uint8_t n_a{0};
  Values value{};
};

/// Board: the answer to Hello, followed by one Dof per DoF.
struct Identity {
  std::uint8_t version{HB_PROTOCOL_VERSION};
  std::uint8_t n_q{0}, n_a{0};
  std::uint8_t capabilities{0};  ///< hb_capability, as bits
  std::uint32_t session{0};      ///< of the Hello it answers
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

/// Board: one sample, unasked, once a sample period.
struct State {
  std::uint64_t time_us{0};         ///< board's clock when q was measured
  std::uint32_t nonce{0};           ///< armed by; 0: not armed
  std::uint32_t command_seq{0};     ///< seq of the newest accepted Command; 0: none yet
  std::uint16_t command_age_us{0};  ///< its age at time_us; 65535: that or more
  std::uint8_t state{HB_DISARMED};  ///< hb_state
  std::uint8_t faults{0};           ///< hb_fault, as bits
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
  std::array<std::uint8_t, HF_MAX_PAYLOAD> bytes{};
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
