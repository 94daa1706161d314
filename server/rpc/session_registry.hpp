#pragma once
/// The sessions and watches that are open, by their secret names.

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "server/session/device_sessions.hpp"
#include "server/session/refusal.hpp"

namespace haptic::server {

class SessionRegistry {
 public:
  /// Session streams and watches are limited apart, so that watchers never keep a controller out.
  explicit SessionRegistry(unsigned limit_of_each) : limit_(limit_of_each) {}

  enum class Kind : std::uint8_t { kSession, kWatch };
  /// A fresh name for a stream on `device`, 128 random bits in hexadecimal: who knows it speaks for
  /// the session. Refused: RESOURCE_EXHAUSTED, unless the session `resumes` the lease of the device,
  /// which no stranger may keep out: that is one more per device at most.
  [[nodiscard]] Outcome<std::string> admit(Kind kind, DeviceSessions& device, bool resumes = false);
  void remove(const std::string& id);
  /// The device of an open session; nullptr where there is none of that name.
  [[nodiscard]] DeviceSessions* find(const std::string& id) const;
  [[nodiscard]] unsigned sessions() const;

 private:
  struct Entry {
    Kind kind{Kind::kSession};
    DeviceSessions* device{nullptr};
  };
  [[nodiscard]] unsigned count(Kind kind) const;

  const unsigned limit_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace haptic::server
