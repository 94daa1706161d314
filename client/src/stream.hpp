#pragma once
/// One Session stream on gRPC's callback API, from its opening to its end.

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "outbox.hpp"

namespace haptic::client {

/// Receives what happens on a stream. Called on gRPC's threads.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  /// One at a time; must not block.
  virtual void on_message(const v1::SessionResponse& message) = 0;
  /// Follows on_message(): tells the user. If delivers_quickly() was false the next message is
  /// being read meanwhile, and calls may overlap.
  virtual void deliver() = 0;
  /// Whether deliver() returns so soon that the next read may wait for it. To start that read first
  /// costs the user's callback as much time as waking a thread.
  [[nodiscard]] virtual bool delivers_quickly() const = 0;
  /// A sample was handed to gRPC; `replaced` samples before it gave way to newer ones.
  virtual void on_sent(std::uint64_t replaced) = 0;
  virtual void on_done(const grpc::Status& status) = 0;
};

class Stream final : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse> {
 public:
  /// `stub` and `sink` must outlive the stream.
  Stream(v1::HapticService::Stub& stub, StreamSink& sink) : stub_(stub), sink_(sink) {}
  ~Stream() override { end(); }

  void start(const v1::OpenSession& open);
  /// From any thread; never waits for the network. Only the newest sample that could not be written
  /// yet is kept.
  void send(v1::SessionRequest sample);
  /// Says LeaveSession, and waits up to `patience` for the server to end the stream. No sample
  /// leaves any more.
  void leave(std::chrono::milliseconds patience);
  /// Ends the stream; on_done() follows soon. Idempotent.
  void cancel();
  /// Cancels, and waits until gRPC no longer uses this object. Not from a call of gRPC's.
  void end();

 private:
  enum class State : std::uint8_t {
    kNew,
    kRunning,
    kBroken,  ///< no further operation may be started
    kDone,    ///< gRPC no longer uses this object
  };
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void write(const v1::SessionRequest* message);
  void break_off();

  v1::HapticService::Stub& stub_;
  StreamSink& sink_;
  grpc::ClientContext context_;
  /// Recursive: gRPC may call back from inside StartWrite on the same thread.
  std::recursive_mutex mutex_;
  std::condition_variable_any changed_;
  State state_{State::kNew};
  Outbox outbox_;
  v1::SessionResponse incoming_;
};

}  // namespace haptic::client
