#pragma once
/// A session's stream, whatever carries it: takes requests, writes what the Session has for the
/// client, and offers the datagram path. The stream's end is the session's.

#include <memory>
#include <string>
#include <utility>

#include "haptic/v1/session.pb.h"
#include "server/front/service/peer.hpp"
#include "server/front/service/response_stream.hpp"
#include "server/front/session/session.hpp"
#include "server/front/udp/session_path.hpp"

namespace haptic::server {

class SessionStream : public ResponseStream {
 public:
  /// `stream`: its carrier.
  SessionStream(ServiceContext& context, Peer peer, Carrier stream)
      : ResponseStream(context, peer.account), peer_(std::move(peer)), stream_(stream) {}

  bool offer(const SerialisedState& state, StateFrame& frame, bool states_allowed) override;
  void goes_on_elsewhere(const std::string& session_id) override;
  void lease_over() override;
  void end_with(const Refusal& why) override { end(why); }
  void report(const std::string& device, v1::GetLinkStatsResponse& response) override;

 protected:
  /// The carrier begins: from now on the stream waits for its first message.
  void begin();
  /// The carrier begins to read the next message; under the mutex.
  virtual void start_read() = 0;
  /// True if a message of so many bytes may be parsed; if not the stream ends.
  [[nodiscard]] bool may_parse(std::size_t bytes);
  /// Takes what start_read() read, of so many bytes.
  void received(const v1::SessionRequest& request, std::size_t bytes, core::TimePoint arrival);
  /// Refuses a message that is no SessionRequest; `why`: "not a SessionRequest".
  void unreadable(const std::string& why);
  /// The carrier is done with it: nothing is called any more.
  void done();

 private:
  void take(const v1::SessionRequest& request, core::TimePoint arrival);
  void open(const v1::OpenSession& request);
  void opened(v1::SessionOpened greeting, const v1::OpenSession& request);
  void offer_udp(v1::SessionOpened& message);
  void flush() override;
  void close(Ending ending) override;
  [[nodiscard]] std::shared_ptr<Session> session();

  const Peer peer_;
  const Carrier stream_;
  bool first_message_{true};  ///< of the reading side: one call at a time

  // Under the mutex.
  std::shared_ptr<Session> session_{};  ///< null before OpenSession
  std::shared_ptr<SessionPath> udp_{};  ///< null: it has no datagram path
  bool opened_{false};
  v1::SessionResponse greeting_;
  bool greeting_due_{false};
};

}  // namespace haptic::server
