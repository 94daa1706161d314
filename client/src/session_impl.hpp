#pragma once
/// A session's state, its worker thread and its streams, one after another.
///
/// Threads: gRPC's deliver messages into fields under mutex_; the worker calls the user's
/// callbacks, asks for force, reconnects. Lock order: none of ours is held while a Stream is
/// called, but for `stream_` itself being copied out.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "haptic/client/session.hpp"
#include "stream.hpp"

namespace haptic::client {

class Session::Impl final : public StreamSink {
 public:
  Impl(std::shared_ptr<grpc::Channel> channel, SessionOptions options);
  ~Impl() override;

  /// Opens the first stream and waits for the server's word. Throws.
  void open();
  void publish(Proxy proxy) noexcept;
  [[nodiscard]] DeviceState state() const;
  [[nodiscard]] DeviceState wait_for_state();
  void engage();
  void want_force(bool wanted);
  void release();
  AppliedSettings update(const Settings& settings);
  [[nodiscard]] bool connected() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const { return device_; }
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  enum class Phase { kOpening, kOpen, kDone };
  struct EngageCall;

  void on_message(const v1::SessionResponse& message) override;
  void on_sent(std::uint64_t samples_replaced) override;
  void on_done(const grpc::Status& status) override;

  /// One attempt at a stream; throws where the server refused or did not answer.
  void connect();
  void work();
  void deliver(std::unique_lock<std::mutex>& lock);
  void handle_end(std::unique_lock<std::mutex>& lock);
  void reconnect(std::unique_lock<std::mutex>& lock);
  void ask_for_force(std::unique_lock<std::mutex>& lock);
  void force_answered(const grpc::Status& status);
  [[nodiscard]] std::string session_id() const;
  void fetch_device();

  const SessionOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  DeviceInfo device_{};

  std::mutex publish_mutex_;  ///< samples leave in the order of their numbers; before mutex_
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Phase phase_{Phase::kDone};
  grpc::Status end_{};
  bool end_pending_{false};  ///< the worker has not dealt with the end yet
  bool closing_{false};
  std::shared_ptr<Stream> stream_;
  v1::SessionOpened opened_{};
  DeviceState newest_{};
  std::uint64_t waited_seq_{0};
  bool state_pending_{false};
  std::deque<Event> events_;
  PublishStatistics statistics_{};
  PublishStatistics earlier_{};  ///< of the streams before this one: the server counts per stream
  std::uint64_t seq_{0};
  Mode last_mode_{Mode::kFree};
  std::uint32_t mode_epoch_{0};
  bool want_force_{false};
  std::shared_ptr<EngageCall> engage_call_;
  Clock::time_point next_engage_{};
  std::chrono::milliseconds backoff_{100};
  Clock::time_point next_connect_{};
  bool reconnecting_{false};
  std::thread worker_;
};

}  // namespace haptic::client
