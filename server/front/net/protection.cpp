#include "server/front/net/protection.hpp"

#include <array>
#include <utility>

namespace haptic::server {

const char* word(Protection protection) noexcept {
  static constexpr std::array kWords{"plain text, this host only", "TLS",
                                     "TLS, clients by certificate",
                                     "PLAIN TEXT, OPEN TO THE NETWORK"};
  return kWords[static_cast<std::size_t>(protection)];
}

std::string weakness(const std::string& address, Protection protection) {
  switch (protection) {
    case Protection::kThisHost:
      return !unix_path(address).empty()
                 ? "gRPC without TLS on " + address + ", open to every user who may open that file"
                 : "gRPC without TLS on " + address + ", open to every user of this host";
    case Protection::kTls:
      return "TLS without client certificates on " + address +
             ": every client that reaches it may take a device that is free, or that a client of a "
             "lower "
             "priority has (PRIORITY_PRIMARY at most)";
    case Protection::kMutualTls:
      return {};
    case Protection::kInsecureLab:
      break;
  }
  return "gRPC without TLS on " + address +
         " (--insecure-lab): every host on that network may read everything, the keys of the UDP "
         "path too, and move the device";
}

std::vector<std::string> weaknesses(const FrontConfig& config) {
  using Use = FrontConfig::Use;
  std::vector<std::string> all;
  for (const FrontConfig::Address& address : config.addresses) {
    if (address.use == Use::kGrpc) {
      std::string weak = weakness(address.name, address.protection);
      if (!weak.empty()) all.push_back(std::move(weak));
    }
    if (address.use == Use::kWeb && address.protection == Protection::kInsecureLab) {
      all.push_back("HTTP without TLS on " + address.name +
                    " (--insecure-lab): every host on that network may read tokens, and move the "
                    "device with them");
    }
  }
  return all;
}

}  // namespace haptic::server
