#include "server/front/session/sample_sender.hpp"

namespace haptic::server {

template <typename Key, typename T>
void SampleSender::flush(std::map<Key, T>& kept, SampleKind kind) {
  while (!kept.empty() && send_sample(socket_.get(), kind, kept.begin()->second)) {
    kept.erase(kept.begin());
  }
}

template <typename Key, typename T>
void SampleSender::send(std::map<Key, T>& kept, SampleKind kind, Key key, const T& value) {
  const std::lock_guard lock(mutex_);
  flush(stops_, SampleKind::kStopAhead);
  flush(kept, kind);
  if (!kept.empty() || !send_sample(socket_.get(), kind, value)) kept.insert_or_assign(key, value);
}

void SampleSender::send(const ProxySample& sample) {
  send(proxies_, SampleKind::kProxy, sample.ticket, sample);
}

void SampleSender::send(const PoseSample& pose) {
  send(poses_, SampleKind::kPose, pose.ticket, pose);
}

void SampleSender::send(const StopAhead& stop) {
  send(stops_, SampleKind::kStopAhead, stop.device, stop);
}

void SampleSender::flush() {
  const std::lock_guard lock(mutex_);
  flush(stops_, SampleKind::kStopAhead);
  flush(proxies_, SampleKind::kProxy);
  flush(poses_, SampleKind::kPose);
}

}  // namespace haptic::server
