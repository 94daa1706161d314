#include "server/rpc/state_frame.hpp"

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
grpc::Slice head(std::uint32_t field_tag, std::uint64_t number) {
  using google::protobuf::io::CodedOutputStream;
  std::array<std::uint8_t, 20> bytes{};
  std::uint8_t* end = CodedOutputStream::WriteVarint32ToArray(field_tag, bytes.data());
  end = CodedOutputStream::WriteVarint64ToArray(number, end);
  return {bytes.data(), static_cast<std::size_t>(end - bytes.data())};
}

grpc::Slice to_slice(const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  grpc::Slice slice(size);
  message.SerializeWithCachedSizesToArray(const_cast<std::uint8_t*>(slice.begin()));
  return slice;
}

}  // namespace

void StateFrame::begin(const StateRecord& state) noexcept {
  record_ = &state;
  ready_ = false;
}

void StateFrame::serialise() {
  if (ready_) return;
  bytes_ = to_slice(message_.write(*record_));
  ready_ = true;
}

grpc::ByteBuffer StateFrame::for_session() {
  serialise();
  const std::array<grpc::Slice, 2> slices{
      head(tag(v1::SessionResponse::kStateFieldNumber, kLengthDelimited), bytes_.size()), bytes_};
  return {slices.data(), slices.size()};
}

std::span<const std::uint8_t> StateFrame::for_datagram() {
  serialise();
  return {bytes_.begin(), bytes_.size()};
}

grpc::ByteBuffer StateFrame::for_watch(std::uint64_t conflated) {
  serialise();
  const std::array<grpc::Slice, 3> slices{
      head(tag(v1::WatchResponse::kStateFieldNumber, kLengthDelimited), bytes_.size()), bytes_,
      head(tag(v1::WatchResponse::kConflatedFieldNumber, kVarint), conflated)};
  return {slices.data(), slices.size()};
}

grpc::ByteBuffer to_buffer(const google::protobuf::MessageLite& message) {
  const grpc::Slice slice = to_slice(message);
  return {&slice, 1};
}

}  // namespace haptic::server
