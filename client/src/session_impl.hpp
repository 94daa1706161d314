#pragma once
/// A session's state, its worker thread and its streams, one after another.
///
/// Threads: gRPC's bring messages into fields under mutex_ and call on_state (session_receive.cpp);
/// the worker calls on_event and on_disconnect, asks for force, reconnects (session_worker.cpp). Lock
/// order: publish_mutex_, then mutex_; no Stream is called and no callback runs with mutex_ held.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "callback_scope.hpp"
#include "haptic/client/session.hpp"
#include "stream.hpp"
#include "udp_path.hpp"

namespace haptic::client {

[[nodiscard]] inline bool has_force(Lifecycle state) noexcept {
  return state == Lifecycle::kEngaging || state == Lifecycle::kEngaged;
}

class Session::Impl final : public StreamSink, public UdpSink {
 public:
  /// `address`: what the channel was made of.
  Impl(std::shared_ptr<grpc::Channel> channel, const std::string& address, SessionOptions options);
  ~Impl() override;

  /// Opens the first stream and waits for the server's word. Throws.
  void open();
  void publish(Proxy proxy) noexcept;
  void publish_pose(const Pose& pose) noexcept;
  [[nodiscard]] DeviceState state() const;
  [[nodiscard]] DeviceState wait_for_state();
  void engage();
  void want_force(bool wanted);
  void release();
  AppliedSettings update(const Settings& settings);
  [[nodiscard]] std::optional<ClientError> engage_refusal() const;
  [[nodiscard]] bool connected() const;
  [[nodiscard]] std::optional<UdpLink> udp_link() const;
  [[nodiscard]] std::uint32_t lease_epoch() const;
  [[nodiscard]] PublishStatistics statistics() const;
  [[nodiscard]] const DeviceInfo& device() const { return device_; }
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;
  enum class Phase { kOpening, kOpen, kDone };
  /// Where callbacks of the user's run, one at a time.
  struct Caller {
    bool on_grpc_thread{false};
    bool busy{false};
  };
  /// One Engage or Release in flight; owns what gRPC writes to.
  template <typename Request, typename Response>
  struct ForceCall {
    grpc::ClientContext context;
    Request request;
    Response response;
  };
  using EngageCall = ForceCall<v1::EngageRequest, v1::EngageResponse>;
  using ReleaseCall = ForceCall<v1::ReleaseRequest, v1::ReleaseResponse>;

  // session_receive.cpp: on gRPC's threads.
  void on_message(const v1::SessionResponse& message) override;
  void deliver() override;
  [[nodiscard]] bool delivers_quickly() const override;
  void on_sent(std::uint64_t samples_replaced) override;
  void on_done(const grpc::Status& status) override;
  void received(const v1::SessionOpened& opened);
  void received(const v1::DeviceState& state);
  void received(const v1::Event& event);
  void received(const v1::SampleAck& ack);

  // session_udp.cpp: on the UDP path's thread.
  void on_udp_state(const v1::DeviceState& state) override;
  void on_udp_fallback(const v1::ProxySample& newest) override;

  /// session_udp.cpp: begins the path that `opened_` offers, if any. Throws where it is required.
  void start_udp(Lock& lock);
  /// Ends the path; without our locks meanwhile.
  void stop_udp(Lock& lock);
  /// By UDP where that is in use. False: the stream should carry it, or carry it too.
  [[nodiscard]] bool send_by_udp(const v1::ProxySample& sample, UdpPath* path);

  /// One attempt at a stream; throws where the server refused or did not answer.
  void connect();
  void fetch_device();
  void set_deadline(grpc::ClientContext& context) const;
  [[nodiscard]] v1::OpenSession opening() const;
  [[nodiscard]] bool controls() const noexcept { return !options_.observer && !options_.tracker; }
  [[nodiscard]] bool resumable() const noexcept {
    return options_.reconnect == Reconnect::kWithBackoff && controls();
  }
  /// Force is asked for again under the lease that follows one that is over.
  [[nodiscard]] bool comes_back_with_force() const noexcept {
    return resumable() && options_.re_engage;
  }
  [[nodiscard]] std::string session_id() const;
  void to_planes(Proxy& proxy) const;
  void leave_for_lease();  ///< under mutex_
  /// A copy for the caller; the next sample is taken to be computed from it. Under mutex_.
  [[nodiscard]] DeviceState hand_out() const;

  // session_worker.cpp: on the worker's thread.
  void work();
  /// The earliest time at which waiting is over without a word from anybody.
  [[nodiscard]] Clock::time_point next_due() const;
  [[nodiscard]] bool force_due() const;
  void deliver_events(Lock& lock);
  void handle_end(Lock& lock);
  void reconnect(Lock& lock);
  /// Runs the user's code without our locks; what it throws ends here.
  template <typename Callback, typename... Arguments>
  void call(Lock& lock, Caller& caller, const Callback& callback, const Arguments&... arguments);

  // session_force.cpp.
  void ask_for_force(Lock& lock);
  void force_answered(const std::string& session_id, const grpc::Status& status);
  [[nodiscard]] bool ends_asking(const std::string& session_id, const grpc::Status& status) const;
  /// Takes back the force that an Engage brought which release() could not wait for.
  void release_again(Lock& lock);
  /// Ends the asking for a reason that waiting must not cure. Under mutex_.
  void give_up_force(const ClientError& why);

  const SessionOptions options_;
  const std::string udp_host_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  DeviceInfo device_{};

  std::mutex publish_mutex_;  ///< samples leave in the order of their numbers
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;  ///< for whoever waits in a call
  std::condition_variable work_;             ///< for the worker: there may be something to do

  // The stream.
  Phase phase_{Phase::kDone};
  std::shared_ptr<Stream> stream_;
  std::shared_ptr<UdpPath> udp_;  ///< stopped by whoever takes it out
  v1::SessionOpened opened_{};
  grpc::Status end_{};
  bool end_pending_{false};  ///< the worker has not dealt with the end yet
  bool closing_{false};
  bool lease_lost_{false};  ///< the stream lives, its lease does not

  // What came down.
  DeviceState newest_{};
  bool state_pending_{false};    ///< on_state has not seen newest_ yet
  std::uint64_t waited_seq_{0};  ///< newest that wait_for_state() returned
  /// The newest that the user was given, and when it had arrived.
  mutable std::uint64_t handed_seq_{0};
  mutable Clock::time_point handed_received_{};
  mutable std::vector<double> handed_x_probe_{};
  std::deque<Event> events_;

  // What goes up.
  PublishStatistics statistics_{};
  PublishStatistics earlier_{};  ///< of the streams before this one: the server counts per stream
  std::uint64_t seq_{0};
  Mode last_mode_{Mode::kFree};
  std::uint32_t mode_epoch_{0};

  // Force.
  bool want_force_{false};
  Clock::time_point asked_at_{};  ///< when the user last asked
  std::shared_ptr<EngageCall> engage_call_;
  std::shared_ptr<ReleaseCall> release_call_;
  /// Released while there was no stream: what is opened next takes up no force, and if it has already
  /// resumed, lets it go.
  bool release_due_{false};
  bool superseded_{false};  ///< by a release() that could not wait for engage_call_
  Clock::time_point next_engage_{};
  std::optional<ClientError> refusal_{};

  // The worker.
  std::chrono::milliseconds backoff_{};
  Clock::time_point next_connect_{};
  bool reconnecting_{false};
  std::thread worker_;

  Caller states_{true}, events_and_end_{};
  int quick_in_a_row_{0};  ///< calls of on_state
};

template <typename Callback, typename... Arguments>
void Session::Impl::call(Lock& lock, Caller& caller, const Callback& callback,
                         const Arguments&... arguments) {
  if (!callback || closing_) return;
  caller.busy = true;
  lock.unlock();
  try {
    const CallbackScope scope(caller.on_grpc_thread);
    callback(arguments...);
  } catch (...) {  // NOLINT(bugprone-empty-catch): the contract: no exception crosses a callback
  }
  lock.lock();
  caller.busy = false;
  changed_.notify_all();  // close() may wait for this
}

}  // namespace haptic::client
