// Requests that a tick answers, over real sockets.
#include <gtest/gtest.h>

#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

constexpr char kServiceName[] = "haptic.v1.HapticService";

class UnaryService : public testing::Test {
 protected:
  UnaryService() : stub(v1::HapticService::NewStub(server.channel())) {}

  grpc::Status stop(const std::string& device, v1::EmergencyStopResponse* response) {
    grpc::ClientContext context;
    v1::EmergencyStopRequest request;
    request.set_device(device);
    request.set_reason("test");
    return stub->EmergencyStop(&context, request, response);
  }
  grpc::Status clear(v1::ClearFaultResponse* response, std::vector<std::uint32_t> ids = {}) {
    grpc::ClientContext context;
    v1::ClearFaultRequest request;
    request.mutable_fault_ids()->Add(ids.begin(), ids.end());
    return stub->ClearFault(&context, request, response);
  }
  grpc::Status update(const v1::UpdateSettingsRequest& request,
                      v1::UpdateSettingsResponse* response) {
    grpc::ClientContext context;
    return stub->UpdateSettings(&context, request, response);
  }

  LiveServer server;
  std::unique_ptr<v1::HapticService::Stub> stub;
};

TEST_F(UnaryService, EngageRefusalGivesReasonAndNumbers) {
  OpenSession session(server.channel());
  session.stream(0.03);
  grpc::Status outside;
  ASSERT_TRUE(eventually([&] {
    outside = session.engage();
    return reason_of(outside) == "OUTSIDE_WINDOW";
  }));
  EXPECT_EQ(outside.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(outside.error_message().find("2.5"), std::string::npos);
}

TEST_F(UnaryService, OversizedMessagesAreRefused) {
  v1::GetServerInfoRequest large;  // read as any request: all of it is of a newer protocol
  large.GetReflection()->MutableUnknownFields(&large)->AddLengthDelimited(99,
                                                                          std::string(70'000, 'x'));
  const auto* const service =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(kServiceName);
  ASSERT_NE(service, nullptr);
  EXPECT_GE(service->method_count(), 9);
  for (int i = 0; i < service->method_count(); ++i) {
    if (service->method(i)->client_streaming()) continue;  // SessionService
    const std::string& name = service->method(i)->name();
    const grpc::Status status =
        raw_call(server.channel(), std::string("/") + kServiceName + "/" + name,
                 large.SerializeAsString())
            .first;
    // Whatever else is in it: a stop is a stop.
    const Refusal expected = name == "EmergencyStop" ? Refusal{grpc::StatusCode::OK, ""}
                                                     : Refusal{grpc::StatusCode::RESOURCE_EXHAUSTED,
                                                               "MESSAGE_TOO_LARGE"};
    EXPECT_EQ(refusal(status), expected) << name;
  }
}

TEST_F(UnaryService, UnknownSessionIsRefused) {
  grpc::ClientContext context;
  v1::EngageRequest request;
  v1::EngageResponse response;
  request.set_session_id("00000000000000000000000000000000");
  const grpc::Status status = stub->Engage(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  v1::UpdateSettingsResponse settings;
  EXPECT_EQ(update({}, &settings).error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(UnaryService, ReleaseFadesForceOut) {
  OpenSession session(server.channel());
  ASSERT_TRUE(session.press());
  grpc::ClientContext context;
  v1::ReleaseRequest request;
  v1::ReleaseResponse response;
  request.set_session_id(session.opened().session_id());
  ASSERT_TRUE(stub->Release(&context, request, &response).ok());
  EXPECT_TRUE(eventually([&] {
    return session.state().state() == v1::DEVICE_STATE_NAME_ARMED &&
           session.state().tau_a(0) == 0.0;
  }));
}

TEST_F(UnaryService, ClampedSettingsAreReported) {
  OpenSession session(server.channel());
  v1::UpdateSettingsRequest request;
  request.set_session_id(session.opened().session_id());
  request.add_stiffness(1e6);
  request.add_force_limit(3.0);
  v1::UpdateSettingsResponse response;
  ASSERT_TRUE(update(request, &response).ok());
  EXPECT_EQ(response.stiffness(0), 100.0);
  EXPECT_EQ(response.force_limit(0), 3.0);
  ASSERT_EQ(response.clamped_size(), 1);
  EXPECT_EQ(response.clamped(0).field(), "stiffness[0]");
  EXPECT_EQ(response.clamped(0).asked(), 1e6);
  EXPECT_EQ(response.clamped(0).applied(), 100.0);
  EXPECT_TRUE(eventually([&] { return session.heard(v1::Event::KIND_CLAMP); }));
  request.add_stiffness(1.0);
  const grpc::Status wrong_size = update(request, &response);
  EXPECT_EQ(wrong_size.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(field_of(wrong_size), "stiffness");
}

TEST_F(UnaryService, UnreadableEmergencyStopStopsEveryDevice) {
  v1::EmergencyStopResponse stopped;
  grpc::ClientContext context;
  v1::EmergencyStopRequest request;
  request.set_device("no such device");
  request.set_reason("\xFF");  // no text: protobuf reads nothing of such a message
  ASSERT_TRUE(stub->EmergencyStop(&context, request, &stopped).ok());
  ASSERT_EQ(stopped.stopped_size(), 1);
  EXPECT_EQ(server.rig.newest().life.state, core::LifecycleState::kFault);
}

TEST_F(UnaryService, EmergencyStopLatchesWithoutASession) {
  OpenSession session(server.channel());
  ASSERT_TRUE(session.press());
  v1::EmergencyStopResponse stopped;
  ASSERT_TRUE(stop("", &stopped).ok());
  ASSERT_EQ(stopped.stopped_size(), 1);
  EXPECT_EQ(stopped.stopped(0), "rig");
  EXPECT_EQ(server.rig.newest().life.state, core::LifecycleState::kFault);
  EXPECT_EQ(server.rig.device->force, 0.0);
  EXPECT_TRUE(eventually([&] { return session.heard(v1::Event::KIND_FAULT); }));
  v1::ClearFaultResponse cleared;
  ASSERT_TRUE(clear(&cleared).ok());
  EXPECT_EQ(clear(&cleared, {32}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_EQ(cleared.cleared_size(), 1);
  EXPECT_EQ(cleared.cleared(0), 7U);
  EXPECT_TRUE(eventually([&] { return session.heard(v1::Event::KIND_FAULT_CLEARED); }));
}

TEST_F(UnaryService, UnknownDeviceNamesTheKnown) {
  const auto expect_refused = [](const grpc::Status& status) {
    EXPECT_EQ(refusal(status), (Refusal{grpc::StatusCode::NOT_FOUND, "NO_SUCH_DEVICE"}));
    EXPECT_NE(status.error_message().find("'rig'"), std::string::npos);
  };
  v1::EmergencyStopResponse stopped;
  expect_refused(stop("thumb", &stopped));
  v1::SessionRequest open = open_message(v1::ROLE_OBSERVER, "alice");
  open.mutable_open()->set_device("thumb");
  expect_refused(TestSession(server.channel(), open).status());
  v1::GetLinkStatsRequest link;
  v1::GetLinkStatsResponse links;
  link.set_device("thumb");
  grpc::ClientContext first, second;
  expect_refused(stub->GetLinkStats(&first, link, &links));
  v1::WatchRequest watch;
  watch.set_device("thumb");
  expect_refused(stub->Watch(&second, watch)->Finish());
}

TEST_F(UnaryService, HangingLoopIsAnsweredAtOnce) {
  server.hung = true;
  v1::EmergencyStopResponse stopped;
  const grpc::Status status = stop("", &stopped);
  EXPECT_EQ(refusal(status), (Refusal{grpc::StatusCode::UNAVAILABLE, "NO_ANSWER"}));
  server.hung = false;
  // The stop was posted all the same.
  EXPECT_TRUE(
      eventually([&] { return server.rig.newest().life.state == core::LifecycleState::kFault; }));
}

TEST_F(UnaryService, ServerInfoAndDevicesAreTrue) {
  OpenSession session(server.channel(), v1::ROLE_CONTROLLER, "alice\n");
  grpc::ClientContext first;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&first, {}, &info).ok());
  EXPECT_EQ(info.version(), "1.2.3");
  EXPECT_EQ(info.protocol(), "haptic.v1");
  EXPECT_EQ(info.sessions(), 1U);
  EXPECT_EQ(info.loop().ticks(), 42U);
  EXPECT_EQ(info.insecure_size(), 1);
  grpc::ClientContext second;
  v1::ListDevicesResponse list;
  ASSERT_TRUE(stub->ListDevices(&second, {}, &list).ok());
  ASSERT_EQ(list.devices_size(), 1);
  const v1::Device& device = list.devices(0);
  EXPECT_EQ(device.name(), "rig");
  EXPECT_EQ(device.controller(), "alice?");
  ASSERT_EQ(device.dofs_size(), 2);
  EXPECT_TRUE(device.dofs(0).actuated());
  EXPECT_EQ(device.dofs(0).max_effort(), 20.0);
  EXPECT_EQ(device.dofs(1).max_effort(), 0.0);
  EXPECT_EQ(device.coordinates_size(), 2);
  EXPECT_EQ(device.stiffness_limit(0), 100.0);
  EXPECT_EQ(device.loop_rate_hz(), 1000.0);
  EXPECT_EQ(device.observers(), 0U);
}

}  // namespace
}  // namespace haptic::test
