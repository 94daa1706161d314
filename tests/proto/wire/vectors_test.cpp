/// The UDP path of proto/README.md against the code. The vectors were computed by two
/// implementations that are not ours (Python's cryptography and a plain AES-GCM by the book).

#include <gtest/gtest.h>

#include <map>

#include "haptic/v1/session.pb.h"
#include "haptic/wire/aead.hpp"
#include "haptic/wire/path_machine.hpp"
#include "tests/proto/markdown.hpp"
#include "tests/proto/wire/hex.hpp"
#include "tests/support/message_text.hpp"

namespace haptic::wire {
namespace {

using test::ByteVector;
using test::from_hex;
using test::markdown_table;
using test::to_hex;
using test::unquoted;

std::string readme() {
  return test::read_text(HAPTIC_SOURCE_DIR "/proto/README.md");
}

DirectionKey documented_key(const std::string& direction) {
  for (const auto& row : markdown_table(readme(), "direction")) {
    if (row.at(0) != direction) continue;
    DirectionKey key;
    const ByteVector bytes = from_hex(unquoted(row.at(1))), salt = from_hex(unquoted(row.at(2)));
    if (bytes.size() != kKeySize || salt.size() != kSaltSize) break;
    std::copy(bytes.begin(), bytes.end(), key.key.begin());
    std::copy(salt.begin(), salt.end(), key.salt.begin());
    return key;
  }
  throw std::runtime_error("no key for " + direction);
}

constexpr std::uint32_t kPathId = 0xc0ffee01;  // of the README

struct Vector {
  std::string name, way;
  std::uint64_t number{0};
  ByteVector payload, datagram;
};

std::vector<Vector> documented_vectors() {
  std::vector<Vector> vectors;
  for (const auto& row : markdown_table(readme(), "vector")) {
    const std::string payload = unquoted(row.at(3));
    vectors.push_back({row.at(0), row.at(1), std::stoull(row.at(2)),
                       from_hex(payload == "-" ? "" : payload), from_hex(unquoted(row.at(4)))});
  }
  return vectors;
}

const std::map<std::string, DatagramType> kTypes = {
    {"PROXY", DatagramType::kProxy},
    {"STATE", DatagramType::kState},
    {"PATH_CHALLENGE", DatagramType::kPathChallenge},
    {"PATH_RESPONSE", DatagramType::kPathResponse},
    {"CLOSE", DatagramType::kClose}};

TEST(UdpVectors, AreSealedToTheByte) {
  const auto vectors = documented_vectors();
  ASSERT_EQ(vectors.size(), 5U);
  for (const Vector& vector : vectors) {
    Sealer sealer(kPathId, documented_key(vector.way), vector.number);
    ByteVector out(kLargestDatagram);
    out.resize(sealer.seal(static_cast<DatagramType>(vector.datagram.at(3)), vector.payload, out));
    EXPECT_EQ(to_hex(out), to_hex(vector.datagram)) << vector.name;
  }
}

TEST(UdpVectors, AreOpened) {
  for (const Vector& vector : documented_vectors()) {
    Opener opener(kPathId, documented_key(vector.way));
    const HeaderReading reading = read_header(vector.datagram);
    ASSERT_EQ(reading.rejection, Rejection::kNone) << vector.name;
    EXPECT_EQ(reading.header.path_id, kPathId);
    EXPECT_EQ(reading.header.packet_number, vector.number);
    ByteVector payload(kLargestPayload);
    const Opened opened = opener.open(reading.header, vector.datagram, payload);
    EXPECT_EQ(opened.rejection, Rejection::kNone) << vector.name;
    payload.resize(opened.size);
    EXPECT_EQ(to_hex(payload), to_hex(vector.payload)) << vector.name;
  }
}

TEST(UdpVectors, PayloadsMatchTheDocumentedMessages) {
  const auto vectors = documented_vectors();
  const auto text = [](const ByteVector& bytes) { return std::string(bytes.begin(), bytes.end()); };
  v1::ProxySample sample;
  ASSERT_TRUE(sample.ParseFromString(text(vectors.at(0).payload)));
  test::expect_text(sample, "seq: 7 mode: PROXY_MODE_HELD position: [0.01, -0.02]");
  v1::DeviceState state;
  ASSERT_TRUE(state.ParseFromString(text(vectors.at(1).payload)));
  test::expect_text(state, "seq: 1000 server_time_ns: 2000000000 x_probe: 0.25");
  EXPECT_EQ(read_challenge(vectors.at(2).payload)->token, 0x0123456789abcdefU);
  const auto response = read_response(vectors.at(3).payload);
  ASSERT_TRUE(response);
  EXPECT_EQ(response->token, 0x0123456789abcdefU);
  EXPECT_EQ(response->received_ns, 5'000'000'000);
  EXPECT_EQ(response->sent_ns, 5'000'001'000);
  EXPECT_EQ(response->packets, 9U);
  EXPECT_EQ(response->newest, 11U);
  EXPECT_TRUE(vectors.at(4).payload.empty());
}

TEST(UdpReadme, TypesAreThoseOfTheCode) {
  const auto rows = markdown_table(readme(), "datagram");
  ASSERT_EQ(rows.size(), kTypes.size());
  for (const auto& row : rows) {
    const auto type = kTypes.find(unquoted(row.at(0)));
    ASSERT_NE(type, kTypes.end()) << row.at(0);
    EXPECT_EQ(std::stoi(row.at(1)), static_cast<int>(type->second));
  }
}

TEST(UdpReadme, ReasonsAndStatesMatchTheCode) {
  const std::string text = readme();
  for (std::size_t i = 1; i < kRejections; ++i) {
    const std::string reason = name(static_cast<Rejection>(i));
    EXPECT_NE(text.find("`" + reason + "`"), std::string::npos) << reason;
  }
  const auto states = markdown_table(text, "path state");
  ASSERT_EQ(states.size(), 4U);
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(unquoted(states[i].at(0)), name(static_cast<PathState>(i)));
  }
}

TEST(UdpReadme, NumbersAreThoseOfTheCode) {
  EXPECT_EQ(kLargestDatagram, 1200U);
  EXPECT_EQ(kLargestPayload, 1168U);
  EXPECT_EQ(ReplayWindow::kSize, 1024U);
  EXPECT_EQ(Sealer::kPacketsPerKey, std::uint64_t{1} << 32U);
  EXPECT_EQ(kShortChallenge + kHeaderSize + kTagSize, 72U);
  for (const char* said : {"at most 1200 bytes", "n = 0..1168", "1023 below", "2^32"}) {
    EXPECT_NE(readme().find(said), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace haptic::wire
