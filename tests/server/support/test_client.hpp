#pragma once
/// A client on the bare stubs: it sends exactly the test's messages.

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "haptic/v1/haptic_service.grpc.pb.h"
#include "tests/server/support/live_server.hpp"

namespace haptic::test {

/// The first detail of that type in a status; a default one if there is none.
template <typename Detail>
Detail detail_in(const grpc::Status& status) {
  google::rpc::Status details;
  Detail found;
  if (!details.ParseFromString(status.error_details())) return found;
  for (const auto& any : details.details()) {
    if (any.UnpackTo(&found)) return found;
  }
  return {};
}

/// ErrorInfo.reason of a status; empty if it has none.
inline std::string reason_of(const grpc::Status& status) {
  return detail_in<google::rpc::ErrorInfo>(status).reason();
}

/// Code of a status, and its reason_of().
using Refusal = std::pair<grpc::StatusCode, std::string>;
inline Refusal refusal(const grpc::Status& status) {
  return {status.error_code(), reason_of(status)};
}

/// Entry `key` of ErrorInfo's metadata; empty if there is none.
inline std::string detail_of(const grpc::Status& status, const std::string& key) {
  const auto info = detail_in<google::rpc::ErrorInfo>(status);
  const auto found = info.metadata().find(key);
  return found != info.metadata().end() ? found->second : std::string();
}

/// Field of the first BadRequest violation of a status; empty if there is none.
inline std::string field_of(const grpc::Status& status) {
  const auto bad = detail_in<google::rpc::BadRequest>(status);
  return bad.field_violations_size() > 0 ? bad.field_violations(0).field() : std::string();
}

/// A call of bytes: its status, and the answer's bytes.
inline std::pair<grpc::Status, std::string> raw_call(const std::shared_ptr<grpc::Channel>& channel,
                                                     const std::string& path,
                                                     const std::string& request) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  const grpc::Slice bytes(request);
  const grpc::ByteBuffer sent(&bytes, 1);
  grpc::ByteBuffer got;
  std::promise<grpc::Status> done;
  stub.UnaryCall(&context, path, {}, &sent, &got,
                 [&](const grpc::Status& status) { done.set_value(status); });
  const grpc::Status status = done.get_future().get();
  grpc::Slice answer;
  if (!got.DumpToSingleSlice(&answer).ok()) return {status, ""};
  return {status, {reinterpret_cast<const char*>(answer.begin()), answer.size()}};
}

inline v1::SessionRequest open_message(v1::Role role, const std::string& name) {
  v1::SessionRequest message;
  message.mutable_open()->set_role(role);
  message.mutable_open()->set_client_name(name);
  if (role == v1::ROLE_CONTROLLER) message.mutable_open()->set_nominal_rate_hz(100.0);
  return message;
}

/// One session stream; a thread reads all responses.
class TestSession {
 public:
  TestSession(const std::shared_ptr<grpc::Channel>& channel, const v1::SessionRequest& first)
      : stub_(v1::HapticService::NewStub(channel)), stream_(stub_->Session(&context_)) {
    send(first);
    reader_ = std::thread([this] { read(); });
  }
  explicit TestSession(const std::shared_ptr<grpc::Channel>& channel,
                       v1::Role role = v1::ROLE_CONTROLLER, const std::string& name = "alice")
      : TestSession(channel, open_message(role, name)) {}

  ~TestSession() {
    context_.TryCancel();
    stop_streaming();
    reader_.join();
    static_cast<void>(status());  // Finish must be called exactly once
  }

  bool send(const v1::SessionRequest& message) {
    const std::lock_guard lock(write_mutex_);
    return !half_closed_ && stream_->Write(message);
  }
  void half_close() {
    const std::lock_guard lock(write_mutex_);
    half_closed_ = true;
    stream_->WritesDone();
  }
  void cancel() { context_.TryCancel(); }

  bool publish(std::vector<double> x, std::uint64_t number,
               v1::ProxyMode mode = v1::PROXY_MODE_HELD) {
    v1::SessionRequest message;
    v1::ProxySample& sample = *message.mutable_proxy();
    sample.set_seq(number);
    sample.set_mode(mode);
    sample.mutable_position()->Add(x.begin(), x.end());
    return send(message);
  }
  bool publish(std::vector<double> x) { return publish(std::move(x), ++seq); }

  /// Publishes `x` at the nominal rate from a thread of its own, whatever else the test does. The
  /// proxy is free until a state says so: the probe comes from outside.
  void stream(std::vector<double> x) {
    {
      const std::lock_guard lock(mutex_);
      streamed_ = std::move(x);
    }
    if (publisher_.joinable()) return;
    streaming_ = true;
    publisher_ = std::thread([this, was_free = false]() mutable {
      auto next = std::chrono::steady_clock::now();
      while (streaming_) {
        const v1::DeviceState now = state();
        was_free = was_free || (now.mode() == v1::PROXY_MODE_FREE &&
                                now.lease_epoch() == opened().lease_epoch());
        publish(get(streamed_), ++seq, was_free ? v1::PROXY_MODE_HELD : v1::PROXY_MODE_FREE);
        next = std::max(next + kPeriod, std::chrono::steady_clock::now());
        std::this_thread::sleep_until(next);
      }
    });
  }
  void stream(double a) { stream({a, 0.0}); }
  void stop_streaming() {
    streaming_ = false;
    if (publisher_.joinable()) publisher_.join();
  }

  /// Streams and asks for force until it is fully on.
  [[nodiscard]] bool press(std::vector<double> x = {0.01, 0.0}) {
    stream(std::move(x));
    return eventually([&] {
      if (state().state() == v1::DEVICE_STATE_NAME_ARMED) static_cast<void>(engage());
      return state().state() == v1::DEVICE_STATE_NAME_ENGAGED;
    });
  }

  grpc::Status engage() {
    grpc::ClientContext context;
    v1::EngageRequest request;
    v1::EngageResponse response;
    request.set_session_id(opened().session_id());
    return stub_->Engage(&context, request, &response);
  }

  [[nodiscard]] bool wait_opened() {
    return eventually([&] { return !opened().session_id().empty() || ended(); }) && !ended();
  }
  [[nodiscard]] bool wait_ended() {
    return eventually([&] { return ended(); });
  }

  [[nodiscard]] v1::SessionOpened opened() { return get(opened_); }
  [[nodiscard]] v1::DeviceState state() { return get(state_); }
  [[nodiscard]] v1::SampleAck ack() { return get(ack_); }
  [[nodiscard]] std::vector<v1::Event> events() { return get(events_); }
  [[nodiscard]] std::vector<std::uint64_t> sequence() { return get(sequence_); }
  [[nodiscard]] bool heard(v1::Event::Kind kind) {
    for (const v1::Event& event : get(events_)) {
      if (event.kind() == kind) return true;
    }
    return false;
  }
  [[nodiscard]] bool ended() { return get(ended_); }
  /// The status the stream ends with; waits for the end.
  [[nodiscard]] grpc::Status status() {
    if (!finished_) {
      if (!wait_ended()) return {grpc::StatusCode::UNKNOWN, "the stream did not end"};
      status_ = stream_->Finish();
      finished_ = true;
    }
    return status_;
  }
  [[nodiscard]] v1::HapticService::Stub& stub() { return *stub_; }
  std::atomic<std::uint64_t> seq{0};

 private:
  static constexpr std::chrono::milliseconds kPeriod{10};

  template <typename T>
  T get(const T& value) {
    const std::lock_guard lock(mutex_);
    return value;
  }

  void read() {
    v1::SessionResponse message;
    while (stream_->Read(&message)) {
      const std::lock_guard lock(mutex_);
      if (message.has_opened()) opened_ = message.opened();
      if (message.has_ack()) ack_ = message.ack();
      if (message.has_event()) events_.push_back(message.event());
      if (message.has_state()) {
        state_ = message.state();
        sequence_.push_back(state_.seq());
      }
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }

  grpc::ClientContext context_;
  std::unique_ptr<v1::HapticService::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SessionRequest, v1::SessionResponse>> stream_;
  std::mutex write_mutex_;
  bool half_closed_{false};
  std::atomic<bool> streaming_{false};
  std::thread publisher_;
  std::mutex mutex_;
  std::vector<double> streamed_;
  v1::SessionOpened opened_;
  v1::DeviceState state_;
  v1::SampleAck ack_;
  std::vector<v1::Event> events_;
  std::vector<std::uint64_t> sequence_;
  bool ended_{false};
  bool finished_{false};
  grpc::Status status_;
  std::thread reader_;
};

/// A session that the server has opened.
struct OpenSession : TestSession {
  template <typename... Arguments>
  explicit OpenSession(const Arguments&... arguments) : TestSession(arguments...) {
    EXPECT_TRUE(wait_opened());
  }
};

}  // namespace haptic::test
