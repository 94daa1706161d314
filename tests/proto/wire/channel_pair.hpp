#pragma once
/// Two ends of a path with keys that a test chose.

#include <string>
#include <vector>

#include "haptic/wire/secure_channel.hpp"
#include "tests/proto/wire/hex.hpp"

namespace haptic::test {

/// Four different keys and salts for every `seed`.
[[nodiscard]] inline wire::PathKeys test_keys(std::uint8_t seed) {
  wire::PathKeys keys;
  keys.path_id = 0x10000U + seed;
  std::uint8_t next = seed;
  for (auto* direction : {&keys.up, &keys.down}) {
    for (auto& byte : direction->key) byte = next = static_cast<std::uint8_t>(next * 5 + 17);
    for (auto& byte : direction->salt) byte = next = static_cast<std::uint8_t>(next * 5 + 17);
  }
  return keys;
}

[[nodiscard]] inline ByteVector bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

/// A channel with vectors in place of buffers.
struct TestEnd {
  TestEnd(wire::End end, const wire::PathKeys& keys) : channel(end, keys) {}

  ByteVector seal(wire::DatagramType type, const std::string& text) {
    ByteVector out(wire::kLargestDatagram);
    out.resize(channel.seal(type, bytes_of(text), out));
    return out;
  }
  /// Content of `datagram`, or the reason why it was rejected.
  std::string open(const ByteVector& datagram, wire::TimePoint now = {}) {
    ByteVector payload(wire::kLargestPayload);
    const wire::Opened opened = channel.open(datagram, payload, now);
    if (opened.rejection != wire::Rejection::kNone) return wire::name(opened.rejection);
    return {payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(opened.size)};
  }
  wire::SecureChannel channel;
};

struct ChannelPair {
  explicit ChannelPair(std::uint8_t seed = 1)
      : client(wire::End::kClient, test_keys(seed)), server(wire::End::kServer, test_keys(seed)) {}
  void rekey(std::uint8_t seed) {
    server.channel.rekey(test_keys(seed));
    client.channel.rekey(test_keys(seed));
  }
  TestEnd client, server;
};

}  // namespace haptic::test
