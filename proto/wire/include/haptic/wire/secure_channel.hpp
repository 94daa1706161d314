#pragma once
/// One end of a path: seals what leaves, opens what comes, and changes keys without a gap.
///
/// Rekey, make-before-break. The server hands new keys out on the stream and goes on sending with
/// the old ones until a datagram under the new ones came: the client has them then. The client
/// sends with the new ones from the moment it has them. What was under way under the old keys is
/// still opened for one second after the new ones were seen in use. A new lease gets a path of its
/// own, not new keys.

#include <optional>

#include "haptic/wire/aead.hpp"
#include "haptic/wire/time.hpp"

namespace haptic::wire {

enum class End : std::uint8_t { kClient, kServer };

/// Not thread-safe.
class SecureChannel {
 public:
  /// How long datagrams sealed with the former keys are still opened.
  static constexpr Duration kOldKeysLast{std::chrono::seconds(1)};
  /// New keys last at least this long. The holder of a key chooses its packet numbers, and must not
  /// be able to force new keys as fast as it likes.
  static constexpr Duration kKeysLastAtLeast{std::chrono::minutes(1)};

  SecureChannel(End end, const PathKeys& keys);

  /// `next` has a path id of its own.
  void rekey(const PathKeys& next);

  /// See Sealer::seal.
  [[nodiscard]] std::size_t seal(DatagramType type, ConstBytes payload, Bytes out) noexcept;
  /// All checks of a datagram (proto/README.md#receiving), up to the commit of the window.
  [[nodiscard]] Opened open(ConstBytes datagram, Bytes payload, TimePoint now) noexcept;

  [[nodiscard]] bool wants_rekey(TimePoint now) const noexcept;
  /// Datagrams of this path id are opened, by whichever keys.
  [[nodiscard]] bool knows(std::uint32_t path_id, TimePoint now) noexcept {
    return opener_of(path_id, now) != nullptr;
  }
  /// Keys handed out that the other end has not used yet.
  [[nodiscard]] bool rekeying() const noexcept { return next_.has_value(); }
  /// Packet number of the newest datagram sent with the keys in use.
  [[nodiscard]] std::uint64_t sent() const noexcept { return current_.sealer.packets(); }
  [[nodiscard]] std::uint32_t path_id() const noexcept { return current_.sealer.path_id(); }

 private:
  struct Keys {
    Keys(End end, const PathKeys& keys);
    Sealer sealer;
    Opener opener;
  };
  [[nodiscard]] Opener* opener_of(std::uint32_t path_id, TimePoint now) noexcept;
  void take_next(TimePoint now) noexcept;

  End end_;
  Keys current_;
  std::optional<TimePoint> current_since_{};  ///< server: the change to them; none: the first keys
  std::optional<Keys> next_{};                ///< server: handed out, not yet seen in use
  std::optional<Keys> former_{};              ///< still opened
  std::optional<TimePoint> former_ends_{};
};

}  // namespace haptic::wire
