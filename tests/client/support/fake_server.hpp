#pragma once
/// A scripted peer on a real loopback socket: says what the test tells it to, remembers what it
/// heard.

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "haptic/client/client.hpp"
#include "haptic/v1/haptic_service.grpc.pb.h"
#include "tests/support/within.hpp"

namespace haptic::test {

/// Runs `action` and returns the ClientError that it throws; fails the test if it throws none.
template <typename Action>
client::ClientError error_of(Action action) {
  try {
    static_cast<void>(action());
  } catch (const client::ClientError& error) {
    return error;
  }
  ADD_FAILURE() << "no ClientError";
  return {client::ErrorReason::kProtocol, "none"};
}

/// A status as hapticd packs it: google.rpc.Status with an ErrorInfo in the details.
[[nodiscard]] grpc::Status refusal(grpc::StatusCode code, const std::string& reason,
                                   const std::string& message);

class FakeServer final
    : public v1::HapticService::WithCallbackMethod_Session<
          v1::HapticService::WithCallbackMethod_Watch<v1::HapticService::Service>> {
 public:
  FakeServer();
  ~FakeServer() override;

  [[nodiscard]] std::string address() const;

  // The script; to be set before it is needed.
  std::atomic<bool> answers_opening{true};          ///< false: hears OpenSession and says nothing
  std::atomic<bool> resumes{false};                 ///< openings that ask to resume are resumed
  void refuse_opening(const grpc::Status& status);  ///< the next OpenSession only
  void offer_udp(const v1::UdpPath& udp);           ///< with every SessionOpened from now on
  void read_samples(bool read);                     ///< false: leaves them in the socket
  void answer_engage(const grpc::Status& status);   ///< queued; OK where the queue is empty
  void hold_engage(bool hold);                      ///< true: Engage is heard but not answered yet

  // Down the newest open session.
  void send_state(std::uint64_t seq, v1::DeviceStateName state = v1::DEVICE_STATE_NAME_ARMED);
  /// `lease_epoch`: the lease it speaks of; the first session holds 1.
  void send_event(v1::Event::Kind kind, const std::string& reason, std::uint32_t lease_epoch = 1,
                  std::int64_t server_time_ns = 0);
  void send(const v1::SessionResponse& message);
  void end_session(const grpc::Status& status);
  /// Down every Watch.
  void send_watch(const v1::WatchResponse& message);
  void end_watch(const grpc::Status& status);

  /// The process dies: sockets close, sessions end. listen() opens the same port again.
  void die();
  void listen();

  /// Messages heard since construction.
  struct Heard {
    std::vector<v1::ProxySample> samples;
    std::vector<v1::TrackerSample> poses;
    std::vector<v1::OpenSession> openings;
    std::size_t engages{0}, releases{0}, farewells{0};
    v1::UpdateSettingsRequest update;  ///< the last one
    v1::WatchRequest watch;            ///< the last one
  };
  [[nodiscard]] Heard heard() const;

  /// Waits for `condition`, which is evaluated without any lock held; false after `patience`. Short
  /// patience is for what must not happen: a slow machine then passes, it never fails.
  template <typename Condition>
  [[nodiscard]] bool until(Condition condition,
                           std::chrono::milliseconds patience = std::chrono::seconds(20)) const {
    return within(patience, condition);
  }

 private:
  class SessionReactor;
  class WatchReactor;
  using Lock = std::unique_lock<std::recursive_mutex>;
  grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>* Session(
      grpc::CallbackServerContext*) override;
  grpc::ServerWriteReactor<v1::WatchResponse>* Watch(grpc::CallbackServerContext*,
                                                     const v1::WatchRequest* request) override;
  grpc::Status ListDevices(grpc::ServerContext*, const v1::ListDevicesRequest*,
                           v1::ListDevicesResponse* response) override;
  grpc::Status Engage(grpc::ServerContext*, const v1::EngageRequest*, v1::EngageResponse*) override;
  grpc::Status Release(grpc::ServerContext*, const v1::ReleaseRequest*,
                       v1::ReleaseResponse*) override;
  grpc::Status UpdateSettings(grpc::ServerContext*, const v1::UpdateSettingsRequest* request,
                              v1::UpdateSettingsResponse* response) override;
  grpc::Status ClearFault(grpc::ServerContext*, const v1::ClearFaultRequest*,
                          v1::ClearFaultResponse*) override;

  /// Recursive: a test's condition may ask for what a reactor holds.
  mutable std::recursive_mutex mutex_;
  mutable std::condition_variable_any changed_;
  std::unique_ptr<grpc::Server> server_;
  int port_{0};
  grpc::Status refusal_;
  bool read_{true};
  std::optional<v1::UdpPath> udp_;
  std::deque<grpc::Status> engage_answers_;
  bool hold_engage_{false};
  std::uint32_t epoch_{0};
  SessionReactor* session_{nullptr};  ///< the newest; null once it ended
  WatchReactor* watch_{nullptr};
  Heard heard_;
};

/// A server, and a client that opens sessions with it.
class WithServer : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<client::Session> open(client::SessionOptions options = {}) {
    return connection.open(std::move(options));
  }
  /// So many samples came by the stream.
  [[nodiscard]] bool streamed(std::size_t samples) {
    return server.until([&] { return server.heard().samples.size() == samples; });
  }
  /// The first sample that arrives.
  [[nodiscard]] v1::ProxySample first_sample() {
    EXPECT_TRUE(server.until([&] { return !server.heard().samples.empty(); }));
    return server.heard().samples.at(0);
  }

  FakeServer server;
  client::Connection connection{server.address()};
};

}  // namespace haptic::test
