#include "udp_carrier.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "remote_session.hpp"

namespace haptic::client {
namespace {

using Clock = std::chrono::steady_clock;

template <std::size_t kSize>
std::array<std::uint8_t, kSize> bytes(const std::string& field) {
  std::array<std::uint8_t, kSize> answer{};
  if (field.size() != kSize) {
    throw ClientError(ErrorReason::kInvalidArgument, "the server's UDP keys have a wrong size");
  }
  std::copy(field.begin(), field.end(), answer.begin());
  return answer;
}

wire::PathKeys to_keys(const v1::UdpPath& offer) {
  return {offer.path_id(),
          {bytes<wire::kKeySize>(offer.up_key()), bytes<wire::kSaltSize>(offer.up_salt())},
          {bytes<wire::kKeySize>(offer.down_key()), bytes<wire::kSaltSize>(offer.down_salt())}};
}

/// The host of an address as gRPC takes it; 127.0.0.1 for a UNIX socket.
std::string host_of(const std::string& address) {
  if (address.rfind("unix:", 0) == 0) return "127.0.0.1";
  std::string host = address;
  for (const char* scheme : {"dns:", "ipv4:", "ipv6:"}) {
    if (host.rfind(scheme, 0) == 0) host.erase(0, std::string(scheme).size());
  }
  host.erase(0, host.rfind('/') + 1);  // the DNS server in "dns://192.0.2.53/robot.example:PORT"
  const std::size_t colon = host.rfind(':');
  if (colon != std::string::npos) host.erase(colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  return host;
}

/// The socket is connected: the kernel passes datagrams of the server only, so one name will do.
constexpr wire::PeerAddress kServer{};

bool fell_back(wire::PathChange change) noexcept {
  return change == wire::PathChange::kSilent || change == wire::PathChange::kLossy ||
         change == wire::PathChange::kClosed;
}

}  // namespace

UdpCarrier::UdpCarrier(const v1::UdpPath& offer, const std::string& stream_address,
                       std::chrono::nanoseconds period, RemoteSession& session)
    : host_(offer.host().empty() ? host_of(stream_address) : offer.host()),
      port_(offer.port()),
      session_(session),
      end_(setup(offer, period)),
      stopping_(::eventfd(0, EFD_CLOEXEC)) {
  thread_ = std::thread([this] { run(); });
}

UdpCarrier::~UdpCarrier() {
  ::close(stopping_);
}

void UdpCarrier::stop() {
  {
    const std::lock_guard lock(mutex_);
    end_.close();
  }
  ::eventfd_write(stopping_, 1);
  if (thread_.joinable()) thread_.join();
}

UdpCarrier::Sent UdpCarrier::send(const v1::ProxySample& sample) {
  const std::lock_guard lock(mutex_);
  if (!end_.in_use()) return Sent::kNo;
  outgoing_.resize(sample.ByteSizeLong());
  sample.SerializeWithCachedSizesToArray(outgoing_.data());
  if (!end_.send(outgoing_)) return Sent::kNo;
  newest_ = sample;
  return end_.in_doubt() ? Sent::kInDoubt : Sent::kYes;
}

void UdpCarrier::rekey(const v1::UdpPath& offer) {
  const wire::PathKeys keys = to_keys(offer);
  const std::lock_guard lock(mutex_);
  end_.rekey(keys);
}

UdpLink UdpCarrier::figures() const {
  const std::lock_guard lock(mutex_);
  return {end_.in_use(), end_.round_trip().smoothed(), end_.counters().received,
          end_.counters().lost};
}

wire::PathEndSetup UdpCarrier::setup(const v1::UdpPath& offer, std::chrono::nanoseconds period) {
  wire::PathEndSetup setup;
  setup.end = wire::End::kClient;
  setup.keys = to_keys(offer);
  setup.rules.nominal_period = period;
  setup.send = [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
    // The system's call: the socket object belongs to the thread. What cannot leave is lost.
    static_cast<void>(
        ::send(handle_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
  };
  return setup;
}

void UdpCarrier::run() {
  asio::error_code error;
  for (const auto& found : Udp::resolver(context_).resolve(host_, std::to_string(port_), error)) {
    addresses_.push_back(found.endpoint());
  }
  if (stopping_ < 0 || !connect()) return;  // the stream goes on alone
  {
    const std::lock_guard lock(mutex_);
    end_.start(kServer, Clock::now());
  }
  wire::TimePoint next_step;
  do {
    drain();  // before any judgement about silence
    next_step = step();
  } while (wait(next_step));
}

/// For a datagram, or until `until`. False: stop() was called.
bool UdpCarrier::wait(wire::TimePoint until) const {
  const auto left = std::max(until - Clock::now(), wire::Duration(0));
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const timespec timeout{seconds.count(), (left - seconds).count()};
  pollfd watched[] = {{handle_, POLLIN, 0}, {stopping_, POLLIN, 0}};
  ::ppoll(watched, std::size(watched), &timeout, nullptr);
  return watched[1].revents == 0;
}

/// To the next of the host's addresses that this system has a route to.
bool UdpCarrier::connect() {
  for (std::size_t i = 0; i < addresses_.size(); ++i) {
    const Udp::endpoint to = addresses_[next_address_++ % addresses_.size()];
    asio::error_code error;
    socket_.close(error);
    socket_.open(to.protocol(), error);
    if (error || socket_.connect(to, error)) continue;
    handle_ = socket_.native_handle();
    return !socket_.non_blocking(true, error);
  }
  handle_ = -1;
  return false;
}

/// Takes all datagrams that wait; only the newest state is passed on.
void UdpCarrier::drain() {
  bool newer = false;
  for (;;) {
    asio::error_code error;
    const std::size_t size = socket_.receive(asio::buffer(buffer_), 0, error);
    if (error == asio::error::connection_refused) continue;  // an answer to an earlier datagram
    if (error) break;                                        // mostly: nothing waits
    newer = take(wire::ConstBytes(buffer_).first(size)) || newer;
  }
  if (newer) session_.on_udp_state(state_);
}

/// Runs `action` on the path. If that leaves it fallen back or in doubt, the newest sample that
/// went by UDP may be lost, and did not go by the stream as well.
template <typename Action>
void UdpCarrier::on_path(Action action) {
  v1::ProxySample newest;
  {
    const std::lock_guard lock(mutex_);
    const bool knew = end_.in_doubt();
    const wire::PathChange change = action();
    if (knew || !(fell_back(change) || end_.in_doubt())) return;
    newest = newest_;
  }
  session_.on_udp_late(newest);
}

/// True for a state newer than the one before.
bool UdpCarrier::take(wire::ConstBytes datagram) {
  bool newer = false;
  on_path([&] {
    const wire::Received received = end_.receive(datagram, kServer, Clock::now());
    if (received.change == wire::PathChange::kUp) address_kept_ = true;
    if (received.message) newer = read(*received.message);
    return received.change;
  });
  return newer;
}

bool UdpCarrier::read(wire::ConstBytes message) {
  if (!incoming_.ParseFromArray(message.data(), static_cast<int>(message.size()))) {
    end_.message_unreadable();
    return false;
  }
  end_.statistics().timed(wire::Duration(incoming_.server_time_ns()), Clock::now());
  if (incoming_.seq() <= state_.seq()) return false;
  state_.Swap(&incoming_);
  return true;
}

wire::TimePoint UdpCarrier::step() {
  wire::TimePoint next;
  on_path([&] {
    const wire::PathChange change = end_.step(Clock::now());
    // A connected UDP socket does not tell whether anything listens there: "localhost" is [::1] and
    // 127.0.0.1, and a server may listen at one of them only.
    const bool another = !address_kept_ && addresses_.size() > 1;
    if (change == wire::PathChange::kRefused && another) static_cast<void>(connect());
    next = end_.next_step();
    return change;
  });
  return next;
}

}  // namespace haptic::client
