#pragma once
/// The host's side of hw/README.md#the-board-protocol without a port or a thread: bytes and time
/// in, bytes and readings out. It reads no clock, so that every rule is tested in virtual time.
///
///   CLOSED --connect()--> GREETING --IDENTITY and every DOF, as expected--> OPEN
///                          ^   '--not as expected--> REFUSED                 |
///                          '---------- nothing heard for kSilence -----------'
///   disconnect() leads to CLOSED from everywhere.

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"
#include "hw/board/clock_map.hpp"
#include "hw/board/expectation.hpp"
#include "hw/board/messages.hpp"
#include "hw/board/sequence_filter.hpp"
#include "hw/firmware/haptic_frame.h"

namespace haptic::hw::board {

/// The loop's wish to the board; the newest counts.
struct Wanted {
  bool arm{false};
  std::uint32_t arming{0};  ///< rises with every new wish to arm
  core::VecA tau_a{};
  core::VecA position{};  ///< n_a: the position to take, instead of tau_a; size 0: a force
};

/// The loop's view of the board.
struct BoardReading {
  bool open{false};    ///< handshake done, board heard from
  bool broken{false};  ///< stopped by its watchdog while this host had armed it, or a fault
  bool force_over_limit{false};  ///< that fault is this one
  std::uint32_t armed{0};        ///< Wanted::arming it follows; 0: none
  std::uint64_t seq{0};          ///< rises with every sample; 0: none yet
  core::TimePoint time{};
  core::VecQ q{};
  core::VecA force{};  ///< size 0 if it measures none
};

/// Counters of the host's side since the link was opened. Every missing frame is in one of them.
struct HostCounters {
  std::uint64_t frames{0};
  std::uint64_t bad_crc{0}, malformed{0}, not_newer{0}, lost{0};
  std::uint64_t sent{0}, commands_held_back{0};  ///< held back: the port took no bytes
  Counters board{};                              ///< the newest of the board's own
};

/// The facts that a board tells in the handshake.
struct Introduction {
  Identity identity{};
  core::VecA drive_damping{};  ///< n_a, N s/m or N m s/rad: 2 max_effort / max_rate
};

class BoardHost {
 public:
  enum class Stage : std::uint8_t { kClosed, kGreeting, kRefused, kOpen };
  static constexpr core::Duration kRepeat{std::chrono::milliseconds(100)};  ///< of HELLO
  static constexpr core::Duration kAgain{std::chrono::milliseconds(20)};    ///< of ARM, DISARM
  static constexpr core::Duration kSilence{std::chrono::milliseconds(250)};

  /// `seed` makes session numbers and nonces: a different one per run.
  BoardHost(Expectation expected, std::uint64_t seed);

  void connect(core::TimePoint now);
  void disconnect();
  void receive(std::span<const std::uint8_t> bytes, core::TimePoint now);
  /// Sends the newest wish to the board.
  void want(const Wanted& wanted, core::TimePoint now);
  /// Repeats requests without an answer. To be called at least every kAgain.
  void poll(core::TimePoint now);

  /// Bytes to write to the port; consume() those that were written.
  [[nodiscard]] std::span<const std::uint8_t> output() const noexcept {
    return {output_.data(), output_length_};
  }
  void consume(std::size_t count) noexcept;

  [[nodiscard]] Stage stage() const noexcept { return stage_; }
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }  ///< of kRefused
  [[nodiscard]] const BoardReading& reading() const noexcept { return reading_; }
  [[nodiscard]] const HostCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] const Identity& identity() const noexcept { return identity_; }
  [[nodiscard]] Introduction introduction() const;  ///< once kOpen
  /// From now on accepts this board only (difference() in expectation.hpp): after the first
  /// handshake, for the case that another board is plugged in. The firmware may be another version,
  /// and the watchdog is checked in every handshake.
  void insist_on(const Identity& board) { known_ = board; }

 private:
  void greet(core::TimePoint now);
  /// The frame in decoder_.
  void on_frame(core::TimePoint now);
  void on_identity();
  [[nodiscard]] std::span<const std::uint8_t> payload() const noexcept {
    return {decoder_.payload, decoder_.payload_length};
  }
  void on_dof(const Dof& dof);
  void on_state(const State& state, core::TimePoint now);
  void follow_arming(const State& state) noexcept;
  void refuse_if(std::string difference);
  template <typename Message>
  void send(hf_type type, const Message& message);
  [[nodiscard]] std::uint32_t new_number(std::uint32_t unlike);

  Expectation expected_;
  std::mt19937_64 random_;
  Stage stage_{Stage::kClosed};
  std::string refusal_{};
  hf_decoder decoder_{};
  SequenceFilter filter_{};
  ClockMap clock_{};
  HostCounters counters_{};
  BoardReading reading_{};

  std::uint32_t session_{0}, tx_seq_{0};
  Identity identity_{};
  std::optional<Identity> known_{};  ///< the board before the port was unplugged
  std::array<std::optional<Dof>, kMaxDofs> dofs_{};
  bool identified_{false};
  core::TimePoint greeted_{}, heard_{}, asked_{};

  Wanted wanted_{};
  std::uint32_t nonce_{0};                 ///< nonce of the present arming; 0: none wanted
  std::uint32_t arming_{0};                ///< Wanted::arming that nonce_ stands for
  std::uint8_t board_state_{HB_DISARMED};  ///< hb_state
  std::uint32_t board_nonce_{0};

  std::array<std::uint8_t, 4 * HF_MAX_WIRE> output_{};
  std::size_t output_length_{0};
};

}  // namespace haptic::hw::board
