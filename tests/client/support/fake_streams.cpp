#include "tests/client/support/fake_streams.hpp"

#include "tests/support/message_text.hpp"

namespace haptic::test {

grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>* FakeServer::Session(
    grpc::CallbackServerContext* /*context*/) {
  return new SessionReactor(*this);  // OnDone deletes it
}

grpc::ServerWriteReactor<v1::WatchResponse>* FakeServer::Watch(
    grpc::CallbackServerContext* /*context*/, const v1::WatchRequest* request) {
  const Lock lock(mutex_);
  heard_.watch = *request;
  return watch_ = new WatchReactor(*this);  // OnDone deletes it
}

void FakeServer::SessionReactor::OnReadDone(bool ok) {
  const Lock lock(server_.mutex_);
  if (!ok) {  // the client half-closed or is gone
    end(grpc::Status::OK);
    return;
  }
  if (request_.has_open()) open();
  if (request_.has_leave()) {
    ++server_.heard_.farewells;
    end(grpc::Status::OK);
    return;
  }
  if (request_.has_proxy()) server_.heard_.samples.push_back(request_.proxy());
  if (request_.has_tracker()) server_.heard_.poses.push_back(request_.tracker());
  paused_ = !server_.read_;
  if (!paused_) StartRead(&request_);
}

void FakeServer::SessionReactor::open() {
  server_.heard_.openings.push_back(request_.open());
  if (!server_.refusal_.ok()) {
    end(std::exchange(server_.refusal_, grpc::Status::OK));
    return;
  }
  if (!server_.answers_opening) return;
  server_.session_ = this;
  v1::SessionResponse message;
  v1::SessionOpened& opened = *message.mutable_opened();
  opened.set_device("finger");
  opened.set_role(request_.open().role());
  opened.mutable_fresh_end()->set_seconds(10);
  opened.set_lease_epoch(++server_.epoch_);
  opened.set_session_id("session-" + std::to_string(server_.epoch_));
  opened.set_resumed(server_.resumes && !request_.open().resume().empty());
  if (server_.udp_) *opened.mutable_udp() = *server_.udp_;
  send(message);
}

void FakeServer::SessionReactor::OnDone() {
  {
    const Lock lock(server_.mutex_);
    if (server_.session_ == this) server_.session_ = nullptr;
  }
  delete this;
}

void FakeServer::WatchReactor::OnDone() {
  {
    const Lock lock(server_.mutex_);
    if (server_.watch_ == this) server_.watch_ = nullptr;
  }
  delete this;
}

grpc::Status FakeServer::ListDevices(grpc::ServerContext* /*context*/,
                                     const v1::ListDevicesRequest* /*request*/,
                                     v1::ListDevicesResponse* response) {
  *response = from_text<v1::ListDevicesResponse>(R"(devices {
    name: "finger"
    dofs { name: "l_x" unit: "m" actuated: true upper: 0.05 }
    coordinates { name: "mcp" unit: "rad" kind: "linear" }
    coordinates { name: "pip" unit: "rad" kind: "linear" } })");
  return grpc::Status::OK;
}

grpc::Status FakeServer::Engage(grpc::ServerContext* /*context*/,
                                const v1::EngageRequest* /*request*/,
                                v1::EngageResponse* /*response*/) {
  Lock lock(mutex_);
  ++heard_.engages;
  changed_.wait(lock, [this] { return !hold_engage_; });
  if (engage_answers_.empty()) return grpc::Status::OK;
  const grpc::Status answer = engage_answers_.front();
  engage_answers_.pop_front();
  return answer;
}

grpc::Status FakeServer::Release(grpc::ServerContext* /*context*/,
                                 const v1::ReleaseRequest* /*request*/,
                                 v1::ReleaseResponse* /*response*/) {
  const Lock lock(mutex_);
  ++heard_.releases;
  return grpc::Status::OK;
}

grpc::Status FakeServer::UpdateSettings(grpc::ServerContext* /*context*/,
                                        const v1::UpdateSettingsRequest* request,
                                        v1::UpdateSettingsResponse* response) {
  const Lock lock(mutex_);
  heard_.update = *request;
  *response = from_text<v1::UpdateSettingsResponse>(R"(
    stiffness: 400 renderer: RENDERER_SUBSPACE_LINEAR
    clamped { field: "stiffness[0]" asked: 900 applied: 400 why: "the scene's limit" })");
  return grpc::Status::OK;
}

grpc::Status FakeServer::ClearFault(grpc::ServerContext* /*context*/,
                                    const v1::ClearFaultRequest* /*request*/,
                                    v1::ClearFaultResponse* /*response*/) {
  return refusal(grpc::StatusCode::FAILED_PRECONDITION, "FAULT_PERSISTS", "DEVICE_LOST persists");
}

}  // namespace haptic::test
