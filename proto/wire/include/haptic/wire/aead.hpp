#pragma once
/// AES-128-GCM of one direction of a path, by OpenSSL's EVP. Key schedule and contexts are set up
/// once; a datagram then costs well under a microsecond and allocates nothing.

#include <cstdint>
#include <memory>

#include "haptic/wire/datagram.hpp"
#include "haptic/wire/path_keys.hpp"
#include "haptic/wire/replay_window.hpp"

struct evp_cipher_ctx_st;

namespace haptic::wire {

using Cipher = std::unique_ptr<evp_cipher_ctx_st, void (*)(evp_cipher_ctx_st*)>;

/// Seals what a direction sends. Not thread-safe.
class Sealer {
 public:
  /// Far below what AES-128-GCM allows, far above one session: 12 days at 4 kHz. At half of it the
  /// server hands out new keys; beyond it nothing is sealed.
  static constexpr std::uint64_t kPacketsPerKey = std::uint64_t{1} << 32U;

  /// `first` is the next packet number: 1, except for test vectors. Throws std::runtime_error if
  /// OpenSSL refuses.
  Sealer(std::uint32_t path_id, const DirectionKey& key, std::uint64_t first = 1);

  /// Header, ciphertext and tag into `out`, under the next packet number; their size. 0, and no
  /// number used, if the payload is above kLargestPayload, `out` too short or the key used up.
  [[nodiscard]] std::size_t seal(DatagramType type, ConstBytes payload, Bytes out) noexcept;

  [[nodiscard]] std::uint32_t path_id() const noexcept { return path_id_; }
  [[nodiscard]] std::uint64_t packets() const noexcept { return next_ - 1; }
  [[nodiscard]] bool wants_rekey() const noexcept { return next_ > kPacketsPerKey / 2; }

 private:
  Cipher cipher_;
  std::array<std::uint8_t, kSaltSize> salt_;
  std::uint32_t path_id_;
  std::uint64_t next_;
};

struct Opened {
  Rejection rejection{Rejection::kNone};
  Header header{};
  std::size_t size{0};  ///< of the payload
};

/// Opens what a direction receives. Not thread-safe.
class Opener {
 public:
  Opener(std::uint32_t path_id, const DirectionKey& key);

  /// The checks from the replay window on (proto/README.md#receiving): window, tag, commit.
  /// `header` comes from read_header() of this datagram; `payload` has room for kLargestPayload
  /// bytes and is undefined after a rejection.
  [[nodiscard]] Opened open(const Header& header, ConstBytes datagram, Bytes payload) noexcept;

  [[nodiscard]] std::uint32_t path_id() const noexcept { return path_id_; }
  [[nodiscard]] std::uint64_t newest() const noexcept { return window_.newest(); }

 private:
  Cipher cipher_;
  std::array<std::uint8_t, kSaltSize> salt_;
  std::uint32_t path_id_;
  ReplayWindow window_{};
};

}  // namespace haptic::wire
