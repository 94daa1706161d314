#pragma once
/// One end of a UDP path, whole: opens what comes, answers challenges, decides whether its own
/// messages go by UDP, and keeps the figures. Sockets and clocks stay outside: datagrams and times
/// come in, datagrams go out by a function.

#include <functional>
#include <optional>

#include "haptic/wire/clock_offset.hpp"
#include "haptic/wire/link_statistics.hpp"
#include "haptic/wire/path_machine.hpp"
#include "haptic/wire/secure_channel.hpp"

namespace haptic::wire {

struct PathEndSetup {
  End end{End::kClient};
  PathKeys keys{};
  PathRules rules{};
  /// Sends a datagram, or drops it; must not block, nor call back.
  std::function<void(const PeerAddress& to, ConstBytes datagram)> send{};
  std::function<std::uint64_t()> token{random_token};
};

/// The fate of a datagram.
struct Received {
  Rejection rejection{Rejection::kNone};
  /// Payload of a PROXY or STATE; lies in the end's own memory until the next call.
  std::optional<ConstBytes> message{};
  PathChange change{PathChange::kNone};
};

/// Datagrams of this end that the other end received, by its newest response, under the keys in
/// use.
struct PeerReport {
  std::uint64_t received{0};
  std::uint64_t newest{0};  ///< highest packet number among them
};

/// Not thread-safe.
class PathEnd {
 public:
  explicit PathEnd(PathEndSetup setup);

  /// Client: begins to probe the server's address.
  void start(const PeerAddress& server, TimePoint now) { machine_.start(server, now); }

  /// A datagram that came at `arrival`, on this end's steady clock. Makes all
  /// checks except those of the message (proto/README.md#receiving). A challenge is answered to
  /// `from`; nothing else is ever answered.
  [[nodiscard]] Received receive(ConstBytes datagram, const PeerAddress& from, TimePoint arrival);
  /// The message of a datagram was none, although the tag was right.
  void message_unreadable() noexcept { statistics_.rejected(Rejection::kPayload); }

  /// Time passed; sends the challenges that are due. Receive what has arrived before.
  PathChange step(TimePoint now);
  [[nodiscard]] TimePoint next_step() const noexcept { return machine_.next_step(); }

  /// Sends a PROXY (client) or STATE (server). False if the path is not in use or the message is
  /// too large: send it on the stream then.
  bool send(ConstBytes message);
  /// Tells the other end that this end leaves the path, and sends no more.
  void close();

  void rekey(const PathKeys& next);
  [[nodiscard]] bool wants_rekey(TimePoint now) const noexcept { return channel_.wants_rekey(now); }
  /// Datagrams of this path id are this end's.
  [[nodiscard]] bool knows(std::uint32_t path_id, TimePoint now) noexcept {
    return channel_.knows(path_id, now);
  }

  [[nodiscard]] bool in_use() const noexcept { return machine_.in_use(); }
  /// In use, but answers are overdue: see PathMachine.
  [[nodiscard]] bool in_doubt() const noexcept { return machine_.in_doubt(); }
  [[nodiscard]] PathState state() const noexcept { return machine_.state(); }
  [[nodiscard]] const PeerAddress& address() const noexcept { return machine_.address(); }
  [[nodiscard]] const RoundTrip& round_trip() const noexcept { return machine_.round_trip(); }
  [[nodiscard]] const LinkCounters& counters() const noexcept { return statistics_.counters(); }
  [[nodiscard]] LinkStatistics& statistics() noexcept { return statistics_; }
  [[nodiscard]] const PeerReport& peer_report() const noexcept { return peer_report_; }
  /// The other end's steady clock against this end's.
  [[nodiscard]] const ClockOffset& clock_offset() const noexcept { return clock_offset_; }

 private:
  void seal_and_send(DatagramType type, ConstBytes payload, const PeerAddress& to);
  void follow_keys();
  void count(const Header& header, std::size_t size, TimePoint arrival);
  [[nodiscard]] bool left_before(const Header& header) const noexcept;
  void answer(const PathChallenge& challenge, std::size_t size, const PeerAddress& to,
              TimePoint arrival);
  [[nodiscard]] PathChange hear(const PathResponse& response, const PeerAddress& from,
                                TimePoint arrival);

  const End end_;
  std::function<void(const PeerAddress&, ConstBytes)> send_;
  SecureChannel channel_;
  PathMachine machine_;
  LinkStatistics statistics_{};
  ClockOffset clock_offset_{};
  PeerReport peer_report_{};
  std::optional<Header> close_{};  ///< the newest CLOSE that came
  std::uint32_t counted_path_;     ///< whose packet numbers the statistics count
  std::uint32_t sending_path_;     ///< whose packet numbers the other end's reports count
  std::array<std::uint8_t, kLargestPayload> payload_{};
  std::array<std::uint8_t, kLargestDatagram> datagram_{};
};

}  // namespace haptic::wire
