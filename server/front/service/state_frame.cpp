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

void StateFrame::begin(const StateRecord& state) noexcept {
  record_ = &state;
  bytes_.reset();
}

void StateFrame::serialise() {
  if (bytes_) return;
  bytes_ = std::make_shared<const std::string>(message_.write(*record_).SerializeAsString());
}

Outgoing StateFrame::for_session() {
  serialise();
  return {head(tag(v1::SessionResponse::kStateFieldNumber, kLengthDelimited), bytes_->size()),
          bytes_,
          {}};
}

std::span<const std::uint8_t> StateFrame::for_datagram() {
  serialise();
  return {reinterpret_cast<const std::uint8_t*>(bytes_->data()), bytes_->size()};
}

Outgoing StateFrame::for_watch(std::uint64_t conflated) {
  serialise();
  return {head(tag(v1::WatchResponse::kStateFieldNumber, kLengthDelimited), bytes_->size()), bytes_,
          head(tag(v1::WatchResponse::kConflatedFieldNumber, kVarint), conflated)};
}

Outgoing to_outgoing(const google::protobuf::MessageLite& message) {
  return {message.SerializeAsString(), {}, {}};
}

}  // namespace haptic::server
