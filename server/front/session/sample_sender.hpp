#pragma once
/// The front's end of the socket for samples. It never waits. If the owner is slower than the
/// clients and the queue is full, what comes is kept here, the newest sample of each sender alone,
/// and goes as soon as there is room: so old samples are lost, and never the newest one. A stop is
/// kept until it is sent.

#include <map>
#include <mutex>

#include "server/crossing/sample_socket.hpp"

namespace haptic::server {

/// Any thread.
class SampleSender {
 public:
  SampleSender() = default;
  explicit SampleSender(Descriptor socket) : socket_(std::move(socket)) {}

  void send(const ProxySample& sample);
  void send(const PoseSample& pose);
  void send(const StopAhead& stop);
  /// Tries again to send what is kept.
  void flush();

 private:
  template <typename Key, typename T>
  void send(std::map<Key, T>& kept, SampleKind kind, Key key, const T& value);
  template <typename Key, typename T>
  void flush(std::map<Key, T>& kept, SampleKind kind);

  Descriptor socket_{};
  std::mutex mutex_{};
  std::map<std::uint32_t, StopAhead> stops_{};      ///< by device
  std::map<std::uint64_t, ProxySample> proxies_{};  ///< by ticket
  std::map<std::uint64_t, PoseSample> poses_{};
};

}  // namespace haptic::server
