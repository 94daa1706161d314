#pragma once
/// Decides if this direction uses UDP, and to which address: challenge, make-before-break, fallback
/// with back-off, return (proto/README.md#the-udp-path). Both ends run one, each for what it sends;
/// the stream is the fallback.
///
///   off ---start---> probing ---4 of 5 came back---> in use ---silent, or lossy---> waiting
///                       |                                                              |
///                       +---fewer came back---> waiting ---back-off over---> probing <-+
///
/// A round is five challenges, padded to 1200 bytes so that what fits later is known to fit, 20 ms
/// apart. In use, short challenges go on ten times per allowed silence: they measure the round trip
/// and are the evidence that both directions live. Silent is a challenge that nothing sent since
/// was answered after, for max(100 ms, 4 nominal periods, 3 round trips).
///
/// Before it is sure of that it is in doubt: an answer is overdue, for longer than this path's
/// round trips vary. What must not be late then goes by the stream as well, so that a path that
/// fails is not felt while the silence is waited for.
///
/// Another address that sends genuine datagrams (a client behind a translator that forgot it)
/// becomes the candidate of a round of its own; what we send stays where it went until that round
/// is passed.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "haptic/wire/link_statistics.hpp"
#include "haptic/wire/path_message.hpp"
#include "haptic/wire/time.hpp"

namespace haptic::wire {

/// An IPv6 address, or an IPv4 one mapped into it, and a port, in host order.
struct PeerAddress {
  std::array<std::uint8_t, 16> ip{};
  std::uint16_t port{0};
  friend bool operator==(const PeerAddress&, const PeerAddress&) = default;
};

struct PathRules {
  Duration nominal_period{std::chrono::milliseconds(16)};  ///< of the samples of this session
  /// An answer is overdue this long after the round trip and four times its variation.
  Duration overdue{std::chrono::milliseconds(30)};
};

enum class PathState : std::uint8_t { kOff, kProbing, kInUse, kWaiting };

/// Change by step() or a message; for events and metrics.
enum class PathChange : std::uint8_t {
  kNone,
  kUp,       ///< waiting or new -> in use
  kMoved,    ///< in use, to another address
  kRefused,  ///< a round failed
  kSilent,   ///< fell back: no answers
  kLossy,    ///< fell back: more than 30 % lost for 1 s
  kClosed,   ///< the other end left the path
};
[[nodiscard]] const char* name(PathState state) noexcept;    ///< "IN_USE"
[[nodiscard]] const char* name(PathChange change) noexcept;  ///< "UDP_UP", "UDP_SILENT", ...

/// A challenge that is to be sent now.
struct DueChallenge {
  PeerAddress to{};
  std::uint64_t token{0};
  std::size_t size{0};  ///< of the payload
};

/// Not thread-safe.
class PathMachine {
 public:
  static constexpr int kChallenges = 5;  ///< per round
  static constexpr int kNeeded = 4;      ///< of them
  static constexpr Duration kSpacing{std::chrono::milliseconds(20)};
  static constexpr Duration kPatience{std::chrono::milliseconds(500)};  ///< after a round's last
  static constexpr Duration kLeastSilence{std::chrono::milliseconds(100)};
  static constexpr double kLossy = 0.30;  ///< share of our datagrams, over one second
  static constexpr Duration kFirstBackoff{std::chrono::milliseconds(500)};
  static constexpr Duration kLongestBackoff{std::chrono::seconds(8)};
  /// In use for so long, the back-off begins again.
  static constexpr Duration kProvenAfter{std::chrono::seconds(10)};

  /// `token` gives unpredictable numbers (random_token).
  PathMachine(const PathRules& rules, std::function<std::uint64_t()> token);

  /// Client: the server's address, from the stream. Begins a round.
  void start(const PeerAddress& to, TimePoint now);
  /// For good, until start().
  void stop() noexcept;
  /// A genuine datagram of the other end. Server: this is how it learns where the client is.
  void heard(const PeerAddress& from, TimePoint now);
  PathChange responded(const PeerAddress& from, const PathResponse& response, TimePoint now);
  /// CLOSE came.
  PathChange closed() noexcept;
  /// New keys: the other end's reports count from the beginning.
  void rekeyed() noexcept { loss_.restart(); }

  /// Time passed. Handle what has arrived before: a program that was stopped must not take the
  /// silence of its own buffers for the path's.
  PathChange step(TimePoint now);
  /// The next challenge due at `now`; call until there is none.
  [[nodiscard]] std::optional<DueChallenge> due(TimePoint now);
  /// Nothing happens before, unless something comes.
  [[nodiscard]] TimePoint next_step() const noexcept;

  [[nodiscard]] PathState state() const noexcept { return state_; }
  [[nodiscard]] bool in_use() const noexcept { return state_ == PathState::kInUse; }
  /// In use, and an answer was overdue at the last step() or response.
  [[nodiscard]] bool in_doubt() const noexcept { return in_doubt_; }
  /// Where our datagrams go while in use.
  [[nodiscard]] const PeerAddress& address() const noexcept { return address_; }
  [[nodiscard]] const RoundTrip& round_trip() const noexcept { return round_trip_; }
  /// The challenge that a response of this token answers left at this time; for ClockOffset.
  [[nodiscard]] std::optional<TimePoint> sent_at(std::uint64_t token) noexcept;
  [[nodiscard]] Duration silence_limit() const noexcept;
  [[nodiscard]] Duration doubt_limit() const noexcept;

 private:
  struct Sent {
    std::uint64_t token{0};
    PeerAddress to{};
    TimePoint at{};
    bool of_round{false};
    bool answered{true};
  };
  struct Round {
    PeerAddress to{};
    int sent{0};
    int answered{0};
    TimePoint next{};
    TimePoint ends{};
  };

  void begin_round(const PeerAddress& to, TimePoint now);
  [[nodiscard]] PathChange pass_round(TimePoint now);
  void fall_back(TimePoint now);
  [[nodiscard]] PathChange judge(TimePoint now);
  void judge_doubt(TimePoint now) noexcept;
  [[nodiscard]] DueChallenge challenge(const PeerAddress& to, std::size_t size, bool of_round,
                                       TimePoint now);
  [[nodiscard]] Sent* find(std::uint64_t token) noexcept;
  void forget_round_challenges() noexcept;

  const PathRules rules_;
  std::function<std::uint64_t()> token_;
  PathState state_{PathState::kOff};
  PeerAddress address_{};
  std::optional<Round> round_{};  ///< while probing; in use: a candidate's
  TimePoint candidate_pause_{};   ///< no new candidate before
  TimePoint restart_pause_{};     ///< what is heard begins no path before
  RoundTrip round_trip_{};
  LossReport loss_{};
  TimePoint up_since_{};
  TimePoint next_challenge_{};
  std::optional<TimePoint> unanswered_since_{};
  bool in_doubt_{false};
  Duration backoff_{0};
  TimePoint retry_at_{};
  static constexpr std::size_t kRemembered = 64;
  std::array<Sent, kRemembered> sent_{};
  std::size_t next_slot_{0};
};

}  // namespace haptic::wire
