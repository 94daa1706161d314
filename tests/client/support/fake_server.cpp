#include "tests/client/support/fake_server.hpp"

#include <chrono>
#include <stdexcept>
#include <utility>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/client/support/fake_streams.hpp"

namespace haptic::test {

namespace {

template <typename Reactor>
Reactor& opened(Reactor* reactor) {
  if (reactor == nullptr) throw std::logic_error("fake server: no client has opened this stream");
  return *reactor;
}

}  // namespace

grpc::Status refusal(grpc::StatusCode code, const std::string& reason, const std::string& message) {
  google::rpc::Status status;
  status.set_code(code);
  status.set_message(message);
  google::rpc::ErrorInfo info;
  info.set_reason(reason);
  info.set_domain("hapticd");
  status.add_details()->PackFrom(info);
  return {code, message, status.SerializeAsString()};
}

FakeServer::FakeServer() {
  listen();
}

FakeServer::~FakeServer() {
  die();
}

void FakeServer::listen() {
  grpc::ServerBuilder builder;
  int bound = 0;
  builder.AddListeningPort("127.0.0.1:" + std::to_string(port_), grpc::InsecureServerCredentials(),
                           &bound);
  builder.RegisterService(this);
  server_ = builder.BuildAndStart();
  if (!server_ || bound == 0) throw std::runtime_error("fake server: cannot listen");
  port_ = bound;
}

std::string FakeServer::address() const {
  return "127.0.0.1:" + std::to_string(port_);
}

void FakeServer::die() {
  hold_engage(false);
  if (server_) server_->Shutdown(std::chrono::system_clock::now());  // cancels every stream
  server_.reset();
}

void FakeServer::refuse_opening(const grpc::Status& status) {
  const Lock lock(mutex_);
  refusal_ = status;
}

void FakeServer::offer_udp(const v1::UdpPath& udp) {
  const Lock lock(mutex_);
  udp_ = udp;
}

void FakeServer::read_samples(bool read) {
  const Lock lock(mutex_);
  if (read && !read_ && session_ != nullptr) session_->read_on();
  read_ = read;
}

void FakeServer::answer_engage(const grpc::Status& status) {
  const Lock lock(mutex_);
  engage_answers_.push_back(status);
}

void FakeServer::hold_engage(bool hold) {
  const Lock lock(mutex_);
  hold_engage_ = hold;
  changed_.notify_all();
}

void FakeServer::send(const v1::SessionResponse& message) {
  const Lock lock(mutex_);
  opened(session_).send(message);
}

void FakeServer::send_state(std::uint64_t seq, v1::DeviceStateName state) {
  v1::SessionResponse message;
  message.mutable_state()->set_seq(seq);
  message.mutable_state()->set_state(state);
  message.mutable_state()->add_x_probe(static_cast<double>(seq));
  send(message);
}

void FakeServer::send_event(v1::Event::Kind kind, const std::string& reason,
                            std::uint32_t lease_epoch, std::int64_t server_time_ns) {
  v1::SessionResponse message;
  message.mutable_event()->set_kind(kind);
  message.mutable_event()->set_reason(reason);
  message.mutable_event()->set_lease_epoch(lease_epoch);
  message.mutable_event()->set_server_time_ns(server_time_ns);
  send(message);
}

void FakeServer::end_session(const grpc::Status& status) {
  const Lock lock(mutex_);
  opened(session_).end(status);
}

void FakeServer::send_watch(const v1::WatchResponse& message) {
  const Lock lock(mutex_);
  opened(watch_).send(message);
}

void FakeServer::end_watch(const grpc::Status& status) {
  const Lock lock(mutex_);
  opened(watch_).end(status);
}

FakeServer::Heard FakeServer::heard() const {
  const Lock lock(mutex_);
  return heard_;
}

}  // namespace haptic::test
