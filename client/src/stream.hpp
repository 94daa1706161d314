#pragma once
/// One Session stream on gRPC's callback API, from its opening to its end.

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <condition_variable>

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "outbox.hpp"

namespace haptic::client {

class RemoteSession;

class Stream final : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse> {
 public:
  /// `stub` and `session`, which is told what happens, must outlive the stream.
  Stream(v1::HapticService::Stub& stub, RemoteSession& session) : stub_(stub), session_(session) {}
  ~Stream() override { end(); }

  /// `patient`: the call waits for a connection instead of failing while there is none. gRPC looks
  /// after a connection that is being made only while a call waits for it, else every 5 s.
  void start(const v1::OpenSession& open, bool patient);
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
  RemoteSession& session_;
  grpc::ClientContext context_;
  /// Recursive: gRPC may call back from inside StartWrite on the same thread.
  std::recursive_mutex mutex_;
  std::condition_variable_any changed_;
  State state_{State::kNew};
  Outbox outbox_;
  v1::SessionResponse incoming_;
};

}  // namespace haptic::client
