#include "udp_path.hpp"

#include <sys/socket.h>

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/steady_timer.hpp>

#include <algorithm>
#include <array>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "haptic/client/error.hpp"
#include "haptic/wire/path_end.hpp"

namespace haptic::client {
namespace {

using asio::ip::udp;
using Clock = std::chrono::steady_clock;

wire::TimePoint now() {
  return wire::TimePoint(
      std::chrono::duration_cast<wire::Duration>(Clock::now().time_since_epoch()));
}

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

/// The socket is connected: the kernel passes datagrams of the server only, so one name will do.
constexpr wire::PeerAddress kServer{};

bool fell_back(wire::PathChange change) noexcept {
  return change == wire::PathChange::kSilent || change == wire::PathChange::kLossy ||
         change == wire::PathChange::kClosed;
}

}  // namespace

class UdpPath::Impl {
 public:
  Impl(const v1::UdpPath& offer, std::string host, std::chrono::nanoseconds period, UdpSink& sink)
      : host_(std::move(host)), port_(offer.port()), sink_(sink), end_(setup(offer, period)) {
    thread_ = std::thread([this] { run(); });
  }

  void stop() {
    {
      const std::lock_guard lock(mutex_);
      if (connected_) end_.close();
    }
    context_.stop();
    if (thread_.joinable()) thread_.join();
  }

  ByUdp send(const v1::ProxySample& sample) {
    const std::lock_guard lock(mutex_);
    if (!end_.in_use()) return ByUdp::kNo;
    outgoing_.resize(sample.ByteSizeLong());
    sample.SerializeWithCachedSizesToArray(outgoing_.data());
    if (!end_.send(outgoing_)) return ByUdp::kNo;
    newest_ = sample;
    return end_.in_doubt() ? ByUdp::kInDoubt : ByUdp::kYes;
  }

  void rekey(const v1::UdpPath& offer) {
    const wire::PathKeys keys = to_keys(offer);
    const std::lock_guard lock(mutex_);
    end_.rekey(keys, wire::OldKeys::kFadeOut);
  }

  [[nodiscard]] UdpFigures figures() const {
    const std::lock_guard lock(mutex_);
    return {end_.in_use(), end_.round_trip().smoothed(), end_.counters().received,
            end_.counters().lost};
  }

 private:
  wire::PathEndSetup setup(const v1::UdpPath& offer, std::chrono::nanoseconds period) {
    wire::PathEndSetup setup;
    setup.end = wire::End::kClient;
    setup.keys = to_keys(offer);
    setup.rules.nominal_period = period;
    setup.send = [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
      // The system's call: the socket object is its own thread's. What cannot leave is lost.
      static_cast<void>(
          ::send(handle_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
    };
    return setup;
  }

  void run() {
    asio::error_code error;
    for (const auto& found : udp::resolver(context_).resolve(host_, std::to_string(port_), error)) {
      addresses_.push_back(found.endpoint());
    }
    if (!connect()) return;  // the stream goes on alone
    {
      const std::lock_guard lock(mutex_);
      connected_ = true;
      end_.start(kServer, now());
    }
    wait_for_datagrams();
    step();
    context_.run();
  }

  /// To the next of the host's addresses that this system has a way to.
  bool connect() {
    for (std::size_t i = 0; i < addresses_.size(); ++i) {
      const udp::endpoint to = addresses_[next_address_++ % addresses_.size()];
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

  /// Under the mutex. A connected UDP socket does not tell whether anybody is there: "localhost" is
  /// [::1] and 127.0.0.1, and a server may listen at one of them. An address that answered once
  /// stays.
  bool try_another(wire::PathChange change) {
    if (change != wire::PathChange::kRefused || answered_ || addresses_.size() < 2) return false;
    ++turn_;
    return connect();
  }

  void wait_for_datagrams() {
    socket_.async_wait(asio::socket_base::wait_read, [this, of = turn_](asio::error_code error) {
      if (error || of != turn_) return;  // a socket that is no more
      drain();
      step();
      if (of == turn_) wait_for_datagrams();
    });
  }

  /// Takes all that waits; only the newest state is told.
  void drain() {
    bool told = true;
    for (;;) {
      asio::error_code error;
      const std::size_t size = socket_.receive(asio::buffer(buffer_), 0, error);
      if (error == asio::error::connection_refused) continue;  // an answer to an earlier datagram
      if (error) break;                                        // mostly: nothing waits
      told = !take(wire::ConstBytes(buffer_).first(size)) && told;
    }
    if (!told) sink_.on_udp_state(state_);
  }

  /// What went by UDP may be lost, and did not go by the stream as well. `knew`: in doubt before.
  bool became_late(wire::PathChange change, bool knew) const {
    return !knew && (fell_back(change) || end_.in_doubt());
  }

  /// True where it was a state newer than the one before.
  bool take(wire::ConstBytes datagram) {
    wire::PathChange change{};
    v1::ProxySample newest;
    bool newer = false, late = false;
    {
      const std::lock_guard lock(mutex_);
      const bool knew = end_.in_doubt();
      const wire::Received received = end_.receive(datagram, kServer, now());
      change = received.change;
      answered_ = answered_ || change == wire::PathChange::kUp;
      if (received.message) newer = read(*received.message);
      late = became_late(change, knew);
      if (late) newest = newest_;
    }
    if (late) sink_.on_udp_fallback(newest);
    return newer;
  }

  bool read(wire::ConstBytes message) {
    if (!incoming_.ParseFromArray(message.data(), static_cast<int>(message.size()))) {
      end_.message_unreadable();
      return false;
    }
    end_.statistics().timed(wire::Duration(incoming_.server_time_ns()), now());
    if (incoming_.seq() <= state_.seq()) return false;
    state_.Swap(&incoming_);
    return true;
  }

  void step() {
    wire::PathChange change{};
    v1::ProxySample newest;
    wire::TimePoint next;
    bool moved = false, late = false;
    {
      const std::lock_guard lock(mutex_);
      const bool knew = end_.in_doubt();
      change = end_.step(now());
      moved = try_another(change);
      late = became_late(change, knew);
      if (late) newest = newest_;
      next = end_.next_step();
    }
    if (late) sink_.on_udp_fallback(newest);
    if (moved) wait_for_datagrams();  // the wait at the former socket ended with it
    if (next == wire::TimePoint::max()) return;
    timer_.expires_at(Clock::time_point(next.time_since_epoch()));
    timer_.async_wait([this](asio::error_code error) {
      if (error) return;
      drain();  // before any judgement about silence
      step();
    });
  }

  const std::string host_;
  const std::uint32_t port_;
  UdpSink& sink_;
  asio::io_context context_{1};
  udp::socket socket_{context_};
  asio::steady_timer timer_{context_};

  mutable std::mutex mutex_;
  wire::PathEnd end_;
  bool connected_{false};
  bool answered_{false};  ///< the address in use, to a whole round of challenges
  int handle_{-1};
  std::vector<std::uint8_t> outgoing_{};
  v1::ProxySample newest_{};  ///< that went by UDP

  // The thread's own.
  std::vector<udp::endpoint> addresses_{};
  std::size_t next_address_{0};
  int turn_{0};  ///< which socket it is that is waited for
  std::array<std::uint8_t, wire::kLargestDatagram> buffer_{};
  v1::DeviceState incoming_{}, state_{};
  std::thread thread_{};
};

UdpPath::UdpPath(const v1::UdpPath& offer, const std::string& host, std::chrono::nanoseconds period,
                 UdpSink& sink)
    : impl_(std::make_unique<Impl>(offer, offer.host().empty() ? host : offer.host(), period,
                                   sink)) {}

UdpPath::~UdpPath() = default;

void UdpPath::stop() {
  impl_->stop();
}
ByUdp UdpPath::send(const v1::ProxySample& sample) {
  return impl_->send(sample);
}
void UdpPath::rekey(const v1::UdpPath& offer) {
  impl_->rekey(offer);
}
UdpFigures UdpPath::figures() const {
  return impl_->figures();
}

std::string udp_host(const std::string& address) {
  if (address.rfind("unix:", 0) == 0) return "127.0.0.1";
  std::string host = address;
  for (const char* scheme : {"dns:", "ipv4:", "ipv6:"}) {
    if (host.rfind(scheme, 0) == 0) host.erase(0, std::string(scheme).size());
  }
  host.erase(0, host.find_first_not_of('/') == std::string::npos ? 0 : host.find_first_not_of('/'));
  const std::size_t colon = host.rfind(':');
  if (colon != std::string::npos) host.erase(colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  return host;
}

}  // namespace haptic::client
