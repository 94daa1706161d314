#include "server/front/service/state_frame.hpp"

#include <array>

#include "google/protobuf/io/coded_stream.h"
#include "haptic/v1/haptic_service.pb.h"

namespace haptic::server {
namespace {

constexpr std::uint32_t tag(int field, std::uint32_t wire_type) {
  return (static_cast<std::uint32_t>(field) << 3U) | wire_type;
}
constexpr std::uint32_t kVarint = 0;
constexpr std::uint32_t kLengthDelimited = 2;

/// Tag and number, as protobuf writes a varint field or the head of a length-delimited one.
std::string head(std::uint32_t field_tag, std::uint64_t number) {
  using google::protobuf::io::CodedOutputStream;
  std::array<std::uint8_t, 20> bytes{};
  std::uint8_t* end = CodedOutputStream::WriteVarint32ToArray(field_tag, bytes.data());
  end = CodedOutputStream::WriteVarint64ToArray(number, end);
  return {bytes.data(), end};
}

}  // namespace

Outgoing StateFrame::framed(int field) {
  const auto message = state_.message();
  if (!bytes_) bytes_ = std::make_shared<const std::string>(message.begin(), message.end());
  return {head(tag(field, kLengthDelimited), message.size()), bytes_, {}};
}

Outgoing StateFrame::for_session() {
  return framed(v1::SessionResponse::kStateFieldNumber);
}

Outgoing StateFrame::for_watch(std::uint64_t conflated) {
  Outgoing outgoing = framed(v1::WatchResponse::kStateFieldNumber);
  outgoing.tail = head(tag(v1::WatchResponse::kConflatedFieldNumber, kVarint), conflated);
  return outgoing;
}

Outgoing to_outgoing(const google::protobuf::MessageLite& message) {
  return {message.SerializeAsString(), {}, {}};
}

}  // namespace haptic::server
