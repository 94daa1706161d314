#include "server/scene/entry_name.hpp"

namespace haptic::server {

void check_entry_name(const FieldReader& reader, const std::string& name, std::size_t longest,
                      std::set<std::string>& taken) {
  const bool well_formed = !name.empty() && name.size() <= longest &&
                           name.find_first_not_of(
                               "abcdefghijklmnopqrstuvwxyz"
                               "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                               "0123456789_-") == std::string::npos;
  if (!well_formed) {
    reader.wrong("name", quoted(name),
                 "must be 1 to " + std::to_string(longest) + " of letters, digits, _ and -");
  } else if (!taken.insert(name).second) {
    reader.wrong("name", quoted(name), "must be another: this one is taken");
  }
}

std::string entry(const char* list, int i) {
  return std::string(list) + "[" + std::to_string(i) + "]";
}

}  // namespace haptic::server
