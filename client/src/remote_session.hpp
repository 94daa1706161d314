#pragma once
/// A session with a server: its worker thread and its streams, one after another.
///
/// Threads: gRPC's and the UDP carrier's bring messages into fields under mutex_ and call on_state
/// (session_receive.cpp). The worker calls on_event and on_disconnect, asks for force and
/// reconnects (session_worker.cpp). Lock order: publish_mutex_, then mutex_. No Stream and no
/// UdpCarrier is called, and no callback runs, with mutex_ held.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "call.hpp"
#include "callback.hpp"
#include "force.hpp"
#include "haptic/client/estimator.hpp"
#include "haptic/client/session.hpp"
#include "newest_state.hpp"
#include "reconnection.hpp"
#include "round_trip.hpp"
#include "stream.hpp"

namespace haptic::client {

class UdpCarrier;

class RemoteSession final : public Session {
 public:
  /// `address`: what the channel was made of.
  RemoteSession(std::shared_ptr<grpc::Channel> channel, const std::string& address,
                SessionOptions options);
  ~RemoteSession() override;

  /// Opens the first stream and waits for the server's answer. Throws.
  void open();

  void publish(Proxy proxy) noexcept override;
  void publish_pose(const Pose& pose) noexcept override;
  [[nodiscard]] DeviceState state() const override;
  [[nodiscard]] DeviceState wait_for_state(
      std::optional<std::chrono::milliseconds> timeout) override;
  void engage() override;
  void engage_when_ready() override;
  [[nodiscard]] std::optional<ClientError> engage_refusal() const override;
  void release() override;
  AppliedSettings update(const Settings& settings) override;
  [[nodiscard]] bool connected() const override;
  [[nodiscard]] std::optional<UdpLink> udp_link() const override;
  [[nodiscard]] std::chrono::nanoseconds round_trip() const override;
  [[nodiscard]] std::uint32_t lease_epoch() const override;
  [[nodiscard]] PublishStatistics statistics() const override;
  [[nodiscard]] const DeviceInfo& device() const override { return device_; }
  void close() override;

  // For Stream, on gRPC's threads (session_receive.cpp).
  /// One at a time; does not block.
  void on_message(const v1::SessionResponse& message);
  /// Follows on_message(): tells the user. If delivers_quickly() was false, the next message is
  /// being read meanwhile, and calls may overlap.
  void deliver();
  /// True if deliver() runs no user's code that may take long. The stream then delivers before it
  /// starts the next read, which spares the callback the time of waking a thread.
  [[nodiscard]] bool delivers_quickly() const;
  /// A sample was handed to gRPC; `replaced` samples before it gave way to newer ones.
  void on_sent(std::uint64_t replaced);
  void on_done(const grpc::Status& status);

  // For UdpCarrier, on its thread (session_udp.cpp).
  void on_udp_state(const v1::DeviceState& state);
  /// Samples go by the stream again, or as well. `newest`, the newest one that went by UDP, may be
  /// lost; its number is 0 if there is none.
  void on_udp_late(const v1::ProxySample& newest);

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;
  /// One of the two threads that call the user.
  struct Caller {
    CallbackThread thread{CallbackThread::kOwn};
    bool busy{false};
  };
  /// One Engage or Release in the background; owns what gRPC writes to.
  template <typename Request, typename Response>
  struct ForceCall {
    explicit ForceCall(const std::string& session_id) {
      request.set_session_id(session_id);
      context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(1));
    }
    grpc::ClientContext context;
    Request request;
    Response response;
  };
  using EngageCall = ForceCall<v1::EngageRequest, v1::EngageResponse>;
  using ReleaseCall = ForceCall<v1::ReleaseRequest, v1::ReleaseResponse>;

  // session_receive.cpp
  void received(const v1::SessionOpened& opened);
  void received(const v1::DeviceState& state);
  void received(const v1::Event& event);
  void received(const v1::SampleAck& ack);

  // session_udp.cpp
  /// Begins to use the path that `opened_` offers, if any. Throws if the user requires one.
  void start_udp(Lock& lock);
  void stop_udp(Lock& lock);
  /// Sends it by UDP if that is in use. False: the stream has to carry the sample, or carry it too.
  [[nodiscard]] bool send_by_udp(const v1::ProxySample& sample, UdpCarrier* udp);

  // remote_session.cpp
  /// One attempt at a stream; throws if the server refused or did not answer. `again`: waits for a
  /// server that is not there, up to the session's timeout.
  void connect(bool again);
  void fetch_device();
  [[nodiscard]] v1::OpenSession opening() const;
  [[nodiscard]] std::string session_id() const;
  [[nodiscard]] bool reconnects() const noexcept {
    return options_.reconnect == Reconnect::kWithBackoff;
  }
  [[nodiscard]] bool resumable() const noexcept {
    return reconnects() && !options_.observer && !options_.tracker;
  }

  // session_publish.cpp
  template <typename Fill>
  void publish_in_order(v1::SessionRequest& request, Fill fill);
  void to_contacts(Proxy& proxy);

  // session_worker.cpp
  void work();
  void deliver_events(Lock& lock);
  void handle_end(Lock& lock);
  void reconnect(Lock& lock);
  /// Runs the user's code without our locks; what it throws ends here.
  template <typename Callback, typename... Arguments>
  void call_user(Lock& lock, Caller& caller, const Callback& callback,
                 const Arguments&... arguments);

  // session_force.cpp
  /// When to send Engage in the background; TimePoint::max() while that is of no use.
  [[nodiscard]] Clock::time_point engage_due() const;
  void send_engage(Lock& lock);
  void send_release(Lock& lock);
  void engage_answered(const std::string& session_id, const grpc::Status& status);

  const SessionOptions options_;
  const std::string address_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stub> stub_;
  DeviceInfo device_{};

  std::mutex publish_mutex_;  ///< samples leave in the order of their numbers
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< wakes calls that wait
  std::condition_variable work_;     ///< wakes the worker

  Reconnection reconnection_;
  std::shared_ptr<Stream> stream_;
  std::shared_ptr<UdpCarrier> udp_;
  v1::SessionOpened opened_{};

  mutable NewestState states_;
  RoundTrip round_trip_;
  std::deque<Event> events_;
  std::int64_t newest_event_ns_{0};  ///< on the server's clock; what the next stream goes on from
  ContactEstimator estimator_{{}, {}};  ///< of SessionOptions::derive_planes
  bool was_free_{false};                ///< a free proxy was published under this lease
  PublishStatistics statistics_{};      ///< `published` is the number of the newest sample
  PublishStatistics earlier_{};  ///< of the streams before this one: the server counts per stream

  Force force_;
  std::shared_ptr<EngageCall> engage_call_;
  std::shared_ptr<ReleaseCall> release_call_;

  Caller on_state_{CallbackThread::kGrpc}, on_event_or_end_{};
  int quick_in_a_row_{0};  ///< calls of on_state
  std::thread worker_;
};

template <typename Callback, typename... Arguments>
void RemoteSession::call_user(Lock& lock, Caller& caller, const Callback& callback,
                              const Arguments&... arguments) {
  if (!callback || reconnection_.closed()) return;
  caller.busy = true;
  lock.unlock();
  call_back(caller.thread, callback, arguments...);
  lock.lock();
  caller.busy = false;
  changed_.notify_all();  // close() may wait for this
}

[[nodiscard]] inline bool has_force(Lifecycle state) noexcept {
  return state == Lifecycle::kEngaging || state == Lifecycle::kEngaged;
}

}  // namespace haptic::client
