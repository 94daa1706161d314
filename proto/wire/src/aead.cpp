#include "haptic/wire/aead.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <stdexcept>

namespace haptic::wire {
namespace {

enum class Way : int { kDecrypt = 0, kEncrypt = 1 };

Cipher make_cipher(const DirectionKey& key, Way way) {
  Cipher cipher(EVP_CIPHER_CTX_new(), EVP_CIPHER_CTX_free);  // which wipes the key
  // GCM's own nonce length, 12 bytes, is the one we use.
  if (!cipher || EVP_CipherInit_ex(cipher.get(), EVP_aes_128_gcm(), nullptr, key.key.data(),
                                   nullptr, static_cast<int>(way)) != 1) {
    throw std::runtime_error("OpenSSL has no AES-128-GCM");
  }
  return cipher;
}

/// Nonce and associated data of one packet; the key stays.
bool begin(EVP_CIPHER_CTX* cipher, const std::array<std::uint8_t, kNonceSize>& nonce,
           ConstBytes associated) noexcept {
  int length = 0;
  return EVP_CipherInit_ex(cipher, nullptr, nullptr, nullptr, nonce.data(), -1) == 1 &&
         EVP_CipherUpdate(cipher, nullptr, &length, associated.data(),
                          static_cast<int>(associated.size())) == 1;
}

bool run(EVP_CIPHER_CTX* cipher, ConstBytes in, std::uint8_t* out) noexcept {
  int length = 0;
  return in.empty() ||
         EVP_CipherUpdate(cipher, out, &length, in.data(), static_cast<int>(in.size())) == 1;
}

}  // namespace

Sealer::Sealer(std::uint32_t path_id, const DirectionKey& key, std::uint64_t first)
    : cipher_(make_cipher(key, Way::kEncrypt)), salt_(key.salt), path_id_(path_id), next_(first) {}

std::size_t Sealer::seal(DatagramType type, ConstBytes payload, Bytes out) noexcept {
  const std::size_t size = kHeaderSize + payload.size() + kTagSize;
  if (payload.size() > kLargestPayload || out.size() < size || next_ > kPacketsPerKey) return 0;
  const Bytes header = out.first(kHeaderSize);
  write_header({type, path_id_, next_}, header.first<kHeaderSize>());
  std::uint8_t* const body = out.data() + kHeaderSize;
  std::uint8_t* const tag = body + payload.size();
  // A number is spent by the first try: a nonce must not come twice, whatever OpenSSL says.
  const auto this_nonce = nonce(salt_, next_++);
  int none = 0;
  const bool sealed =
      begin(cipher_.get(), this_nonce, header) && run(cipher_.get(), payload, body) &&
      EVP_CipherFinal_ex(cipher_.get(), tag, &none) == 1 &&
      EVP_CIPHER_CTX_ctrl(cipher_.get(), EVP_CTRL_AEAD_GET_TAG, static_cast<int>(kTagSize), tag) ==
          1;
  return sealed ? size : 0;
}

Opener::Opener(std::uint32_t path_id, const DirectionKey& key)
    : cipher_(make_cipher(key, Way::kDecrypt)), salt_(key.salt), path_id_(path_id) {}

Opened Opener::open(const Header& header, ConstBytes datagram, Bytes payload) noexcept {
  Opened answer{window_.check(header.packet_number), header, 0};
  // No true end seals it. Accepted it would make all that follow too old, and count 2^64 as lost.
  if (header.packet_number > Sealer::kPacketsPerKey) answer.rejection = Rejection::kTag;
  if (answer.rejection != Rejection::kNone) return answer;
  const ConstBytes body = datagram.subspan(kHeaderSize, datagram.size() - kHeaderSize - kTagSize);
  std::array<std::uint8_t, kTagSize> tag{};
  std::copy_n(datagram.end() - kTagSize, kTagSize, tag.begin());
  int none = 0;
  std::array<std::uint8_t, kTagSize> nothing_left{};
  const bool genuine =
      payload.size() >= body.size() &&
      begin(cipher_.get(), nonce(salt_, header.packet_number), datagram.first(kHeaderSize)) &&
      run(cipher_.get(), body, payload.data()) &&
      EVP_CIPHER_CTX_ctrl(cipher_.get(), EVP_CTRL_AEAD_SET_TAG, static_cast<int>(kTagSize),
                          tag.data()) == 1 &&
      EVP_CipherFinal_ex(cipher_.get(), nothing_left.data(), &none) == 1;
  if (!genuine) {
    answer.rejection = Rejection::kTag;
    return answer;
  }
  window_.commit(header.packet_number);
  answer.size = body.size();
  return answer;
}

}  // namespace haptic::wire
