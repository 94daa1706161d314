#pragma once
/// The client's end of a session's UDP path: a socket and a thread around wire::PathEnd.

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic/client/types.hpp"
#include "haptic/v1/session.pb.h"
#include "haptic/wire/path_end.hpp"

namespace haptic::client {

class RemoteSession;

class UdpCarrier {
 public:
  /// The answer to: did a sample go by UDP?
  enum class Sent : std::uint8_t {
    kNo,       ///< no: the path is not in use
    kInDoubt,  ///< yes, but answers are overdue: the stream should carry the sample too
    kYes,
  };
  /// `stream_address`: the channel's; its host is used if the offer names none. `period`: time
  /// between two samples or states, by which the path's silence is judged. The carrier calls
  /// `session` on its own thread with states and late samples, and holds no lock meanwhile. Throws
  /// ClientError if the offer's keys are wrong.
  UdpCarrier(const v1::UdpPath& offer, const std::string& stream_address,
             std::chrono::nanoseconds period, RemoteSession& session);
  /// Only after stop().
  ~UdpCarrier();
  UdpCarrier(const UdpCarrier&) = delete;
  UdpCarrier& operator=(const UdpCarrier&) = delete;

  /// Leaves the path and ends the thread; waits for a call of the session that is under way. Not
  /// from there. Idempotent.
  void stop();
  /// From any thread; never waits for the network.
  [[nodiscard]] Sent send(const v1::ProxySample& sample);
  /// New keys came on the stream.
  void rekey(const v1::UdpPath& offer);
  [[nodiscard]] UdpLink figures() const;

 private:
  using Udp = asio::ip::udp;

  [[nodiscard]] wire::PathEndSetup setup(const v1::UdpPath& offer, std::chrono::nanoseconds period);
  void run();
  [[nodiscard]] bool connect();
  [[nodiscard]] bool wait(wire::TimePoint until) const;
  void drain();
  [[nodiscard]] bool take(wire::ConstBytes datagram);
  [[nodiscard]] bool read(wire::ConstBytes message);
  [[nodiscard]] wire::TimePoint step();
  template <typename Action>
  void on_path(Action action);

  const std::string host_;
  const std::uint32_t port_;
  RemoteSession& session_;
  asio::io_context context_{1};
  Udp::socket socket_{context_};

  mutable std::mutex mutex_;
  wire::PathEnd end_;
  const int stopping_;        ///< an eventfd
  bool address_kept_{false};  ///< a whole round was answered: no other address is tried
  int handle_{-1};
  std::vector<std::uint8_t> outgoing_{};
  v1::ProxySample newest_{};  ///< that went by UDP

  // The thread's own.
  std::vector<Udp::endpoint> addresses_{};
  std::size_t next_address_{0};
  std::array<std::uint8_t, wire::kLargestDatagram> buffer_{};
  v1::DeviceState incoming_{}, state_{};
  std::thread thread_{};
};

}  // namespace haptic::client
