#include "server/owner/scene/removed.hpp"

#include <map>

namespace haptic::server {

std::string removed_field(const std::string& name) {
  static const std::map<std::string, std::string> kAdvice{
      {"monotone_envelope", "0.1.0: delete the line; the direction guard is on by default"},
      {"passivity_certificate",
       "0.1.0: delete the line; the energy tank bounds what the force gives out"},
      {"coupling_metric", "0.1.0: delete the line; states carry no metric any more"},
  };
  const auto found = kAdvice.find(name);
  return found == kAdvice.end() ? "" : "`" + name + "` was removed in " + found->second;
}

}  // namespace haptic::server
