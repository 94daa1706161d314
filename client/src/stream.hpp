#pragma once
/// One Session stream on gRPC's callback API, from open to done. It owns gRPC's rule of one
/// outstanding write: send() keeps only the newest sample that could not be written yet.

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "haptic/v1/haptic_service.grpc.pb.h"

namespace haptic::client {

/// Where a stream's messages go. Called on gRPC's threads; on_message() one at a time, and it must
/// not block.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  virtual void on_message(const v1::SessionResponse& message) = 0;
  /// After on_message(): tell the user. May overlap with calls for later messages where
  /// delivers_quickly() was false: the next message is then being read already.
  virtual void deliver() = 0;
  /// deliver() will not take its time. To ask for the next message costs as much as a wake-up, and
  /// may then wait.
  [[nodiscard]] virtual bool delivers_quickly() const = 0;
  /// One sample was handed over; so many before it gave way to newer ones.
  virtual void on_sent(std::uint64_t samples_replaced) = 0;
  virtual void on_done(const grpc::Status& status) = 0;
};

class Stream final : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse> {
 public:
  /// `stub` and `sink` must outlive the stream.
  Stream(v1::HapticService::Stub& stub, StreamSink& sink);
  ~Stream() override;

  void start(const v1::OpenSession& open);
  /// Any thread; never waits for the network.
  void send(const v1::ProxySample& sample);
  void send(const v1::TrackerSample& sample);
  /// Says LeaveSession, and waits for the server to end the stream, for at most `patience`. No sample
  /// leaves any more.
  void leave(std::chrono::milliseconds patience);
  /// Ends the stream; on_done() follows soon. Idempotent.
  void cancel();
  /// The same, and waits: gRPC is then through with this object. Not from a call of gRPC's.
  void end();

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void keep_newest(v1::SessionRequest request);
  void write_locked();
  void write_leave_locked();

  v1::HapticService::Stub& stub_;
  StreamSink& sink_;
  grpc::ClientContext context_;
  /// Recursive: gRPC may call back from inside StartWrite on the same thread.
  std::recursive_mutex mutex_;
  std::condition_variable_any changed_;
  v1::SessionRequest outgoing_;
  v1::SessionResponse incoming_;
  std::optional<v1::SessionRequest> pending_;
  std::uint64_t replaced_{0};
  bool started_{false};
  bool writing_{false};
  bool leaving_{false};
  bool broken_{false};  ///< no further operation may be started
  bool held_{false};    ///< our hold on the call, which keeps send() legal
  bool done_{false};
};

}  // namespace haptic::client
