#pragma once
/// A session's state, its worker thread and its streams, one after another.
///
/// Threads: gRPC's deliver messages into fields under mutex_; the worker calls the user's callbacks,
/// asks for force, reconnects. Lock order: publish_mutex_, then mutex_; neither a Stream nor the user
/// is called with mutex_ held.

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
  void engage_when_ready();
  void release();
  AppliedSettings update(const Settings& settings);
  [[nodiscard]] bool connected() const;
  [[nodiscard]] Transport transport() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const { return device_; }
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;
  enum class Phase : std::uint8_t { kOpening, kOpen, kDone };
  struct EngageCall;

  void on_message(const v1::SessionResponse& message) override;
  void on_sent() override;
  void on_done(const grpc::Status& status) override;
  void take_event(const v1::Event& message);
  void take_ack(const v1::SampleAck& ack);

  /// One attempt at a stream; throws where the server refused or did not answer.
  void connect();
  void fetch_device();
  [[nodiscard]] v1::OpenSession open_message() const;
  [[nodiscard]] v1::ProxySample make_sample(Proxy& proxy);
  /// Of the open session; throws kClosed where there is none.
  [[nodiscard]] std::string session_id() const;
  void set_deadline(grpc::ClientContext& context) const;
  void remember_handed(const DeviceState& state) const;

  void work();
  [[nodiscard]] Clock::time_point next_due() const;
  void deliver(Lock& lock);
  void handle_end(Lock& lock);
  void reconnect(Lock& lock);
  void give_up(Lock& lock, const ClientError& error);
  void ask_for_force(Lock& lock);
  void force_answered(const grpc::Status& status);

  const SessionOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  DeviceInfo device_{};

  std::mutex publish_mutex_;  ///< keeps samples in the order of their numbers
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Phase phase_{Phase::kDone};
  grpc::Status end_{};
  bool end_pending_{false};  ///< the worker has not dealt with the end yet
  bool closing_{false};
  bool ended_{false};  ///< no stream any more, and none to come
  std::shared_ptr<Stream> stream_;
  v1::SessionOpened opened_{};

  DeviceState newest_{};
  std::uint64_t waited_seq_{0};
  bool state_pending_{false};
  std::deque<Event> events_;
  mutable std::uint64_t handed_seq_{0};  ///< newest state the user has seen, and when it came
  mutable Clock::time_point handed_received_{};

  PublishStatistics statistics_{};
  PublishStatistics before_{};  ///< the server's counts on earlier streams
  std::uint64_t seq_{0};
  Mode last_mode_{Mode::kFree};
  std::uint32_t mode_epoch_{1};

  bool want_force_{false};  ///< the user asked for force and did not give it up
  bool asking_{false};      ///< ... and the server has not agreed yet
  std::shared_ptr<EngageCall> engage_call_;
  Clock::time_point next_engage_{};

  bool lease_lost_{false};  ///< expired: the stream goes on as observer
  bool renew_{false};       ///< ... and the user publishes again
  bool reconnecting_{false};
  std::chrono::milliseconds backoff_{};
  Clock::time_point next_connect_{};
  std::thread worker_;
};

}  // namespace haptic::client
