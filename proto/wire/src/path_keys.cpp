#include "haptic/wire/path_keys.hpp"

#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>

#include "haptic/wire/datagram.hpp"

namespace haptic::wire {
namespace {

void fill(Bytes bytes) {
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    throw std::runtime_error("OpenSSL has no random numbers");
  }
}

}  // namespace

PathKeys fresh_keys() {
  PathKeys keys;
  while (keys.path_id == 0) keys.path_id = static_cast<std::uint32_t>(random_token());
  for (DirectionKey* direction : {&keys.up, &keys.down}) {
    fill(direction->key);
    fill(direction->salt);
  }
  return keys;
}

std::uint64_t random_token() {
  std::array<std::uint8_t, 8> bytes{};
  fill(bytes);
  return get<std::uint64_t>(bytes);
}

std::array<std::uint8_t, kNonceSize> nonce(const std::array<std::uint8_t, kSaltSize>& salt,
                                           std::uint64_t packet_number) noexcept {
  std::array<std::uint8_t, kNonceSize> answer{};
  std::copy(salt.begin(), salt.end(), answer.begin());
  put(packet_number, Bytes(answer).subspan(kSaltSize));
  return answer;
}

}  // namespace haptic::wire
