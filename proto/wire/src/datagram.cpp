#include "haptic/wire/datagram.hpp"

#include <algorithm>
#include <iterator>

namespace haptic::wire {

const char* name(Rejection rejection) noexcept {
  constexpr const char* kNames[] = {"NONE",         "LENGTH",    "MAGIC",   "VERSION", "TYPE",
                                    "UNKNOWN_PATH", "DUPLICATE", "TOO_OLD", "TAG",     "PAYLOAD"};
  const auto number = static_cast<std::size_t>(rejection);
  return number < std::size(kNames) ? kNames[number] : "UNKNOWN";
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
          {static_cast<DatagramType>(type), get<std::uint32_t>(datagram.subspan(4)),
           get<std::uint64_t>(datagram.subspan(8))}};
}

void write_header(const Header& header, std::span<std::uint8_t, kHeaderSize> out) noexcept {
  std::copy(kMagicBytes.begin(), kMagicBytes.end(), out.begin());
  out[2] = kProtocolVersion;
  out[3] = static_cast<std::uint8_t>(header.type);
  put(header.path_id, out.subspan(4));
  put(header.packet_number, out.subspan(8));
}

}  // namespace haptic::wire
