#include "haptic/client/session.hpp"

#include "session_impl.hpp"

namespace haptic::client {

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::~Session() = default;

void Session::publish(Proxy proxy) noexcept {
  impl_->publish(std::move(proxy));
}
void Session::publish_pose(const Pose& pose) noexcept {
  impl_->publish_pose(pose);
}
DeviceState Session::state() const {
  return impl_->state();
}
DeviceState Session::wait_for_state() {
  return impl_->wait_for_state();
}
void Session::engage() {
  impl_->engage();
}
void Session::engage_when_ready() {
  impl_->want_force(true);
}
std::optional<ClientError> Session::engage_refusal() const {
  return impl_->engage_refusal();
}
void Session::release() {
  impl_->release();
}
AppliedSettings Session::update(const Settings& settings) {
  return impl_->update(settings);
}
bool Session::connected() const {
  return impl_->connected();
}
std::optional<UdpLink> Session::udp_link() const {
  return impl_->udp_link();
}
std::uint32_t Session::lease_epoch() const {
  return impl_->lease_epoch();
}
PublishStatistics Session::statistics() const {
  return impl_->statistics();
}
const DeviceInfo& Session::device() const {
  return impl_->device();
}
void Session::close() {
  impl_->close();
}

}  // namespace haptic::client
