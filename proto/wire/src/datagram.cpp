#include "haptic/wire/datagram.hpp"

#include <algorithm>

namespace haptic::wire {
namespace {

template <typename Number>
void put_number(Number value, Bytes out) noexcept {
  for (std::size_t i = sizeof(Number); i-- > 0; value = static_cast<Number>(value >> 8U)) {
    out[i] = static_cast<std::uint8_t>(value & 0xFFU);
  }
}

template <typename Number>
Number get_number(ConstBytes in) noexcept {
  Number value = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    value = static_cast<Number>((value << 8U) | in[i]);
  }
  return value;
}

}  // namespace

void put(std::uint32_t value, Bytes out) noexcept {
  put_number(value, out);
}
void put(std::uint64_t value, Bytes out) noexcept {
  put_number(value, out);
}
std::uint32_t get_u32(ConstBytes in) noexcept {
  return get_number<std::uint32_t>(in);
}
std::uint64_t get_u64(ConstBytes in) noexcept {
  return get_number<std::uint64_t>(in);
}

const char* name(Rejection rejection) noexcept {
  switch (rejection) {
    case Rejection::kNone:
      return "NONE";
    case Rejection::kLength:
      return "LENGTH";
    case Rejection::kMagic:
      return "MAGIC";
    case Rejection::kVersion:
      return "VERSION";
    case Rejection::kType:
      return "TYPE";
    case Rejection::kUnknownPath:
      return "UNKNOWN_PATH";
    case Rejection::kDuplicate:
      return "DUPLICATE";
    case Rejection::kTooOld:
      return "TOO_OLD";
    case Rejection::kTag:
      return "TAG";
    case Rejection::kPayload:
      return "PAYLOAD";
  }
  return "UNKNOWN";
}

HeaderReading read_header(ConstBytes datagram) noexcept {
  if (datagram.size() < kHeaderSize + kTagSize || datagram.size() > kLargestDatagram) {
    return {Rejection::kLength, {}};
  }
  if (!std::equal(kMagicBytes.begin(), kMagicBytes.end(), datagram.begin()))
    return {Rejection::kMagic, {}};
  if (datagram[2] != kProtocolVersion) return {Rejection::kVersion, {}};
  const std::uint8_t type = datagram[3];
  if (type < static_cast<std::uint8_t>(DatagramType::kProxy) ||
      type > static_cast<std::uint8_t>(DatagramType::kClose)) {
    return {Rejection::kType, {}};
  }
  return {Rejection::kNone,
          {static_cast<DatagramType>(type), get_u32(datagram.subspan(4)),
           get_u64(datagram.subspan(8))}};
}

void write_header(const Header& header, std::span<std::uint8_t, kHeaderSize> out) noexcept {
  std::copy(kMagicBytes.begin(), kMagicBytes.end(), out.begin());
  out[2] = kProtocolVersion;
  out[3] = static_cast<std::uint8_t>(header.type);
  put(header.path_id, out.subspan(4));
  put(header.packet_number, out.subspan(8));
}

}  // namespace haptic::wire
