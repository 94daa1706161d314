#pragma once
/// The sessions and watches that are open, by their secret names.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/crossing/outcome.hpp"

namespace haptic::server {

class SessionRegistry {
 public:
  /// Controllers and trackers, observers, and watches are limited apart, so that a client that only
  /// looks never keeps a controller out.
  explicit SessionRegistry(unsigned limit_of_each) : limit_(limit_of_each) {}

  using Kind = Request::Kind;  ///< kAdmit...
  /// A fresh name for a stream on `device`. Refused: RESOURCE_EXHAUSTED. A session that `resumes`
  /// the lease of the device has as many places more, which no stranger can take from it; they have
  /// an end as well, because a front may ask again and again.
  [[nodiscard]] Outcome<SessionId> admit(Kind kind, std::size_t device, bool resumes = false);
  void remove(const SessionId& id);
  /// The device of an open session or watch; absent: there is none of that name.
  [[nodiscard]] std::optional<std::size_t> device_of(const SessionId& id) const;
  /// Those that are open, and what each is.
  [[nodiscard]] std::vector<std::pair<SessionId, Kind>> all() const;
  [[nodiscard]] unsigned count(Kind kind, std::optional<std::size_t> device = {}) const;

 private:
  struct Entry {
    Kind kind{Kind::kAdmitSession};
    std::size_t device{0};
  };
  const unsigned limit_;
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace haptic::server
