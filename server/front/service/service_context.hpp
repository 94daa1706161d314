#pragma once
/// State that the calls of the service share, whatever carries them.

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "haptic/v1/haptic_service.pb.h"
#include "server/crossing/front_config.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/front/service/broadcaster.hpp"
#include "server/front/service/service_limits.hpp"
#include "server/front/session/front.hpp"
#include "server/front/session/session.hpp"
#include "server/front/udp/udp_port.hpp"

namespace haptic::server {

class OpenStream;

/// The streams that a carrier, or an answer on its way, still holds, so that shutdown can end them
/// and wait for the last.
class OpenStreams {
 public:
  void add(const std::shared_ptr<OpenStream>& stream);
  /// From now on streams that are added are closed at once.
  void close_all();
  /// Calls `visit` with each that is open, with no lock held.
  void for_each(const std::function<void(OpenStream&)>& visit) const;
  /// Until every stream was destroyed.
  void wait_until_gone();

 private:
  friend class OpenStream;
  [[nodiscard]] std::vector<std::shared_ptr<OpenStream>> open() const;

  mutable std::mutex mutex_;
  std::condition_variable gone_;
  bool closing_{false};
  std::size_t alive_{0};
  std::unordered_map<const OpenStream*, std::weak_ptr<OpenStream>> streams_;
};

/// Streams that cost memory and have earned no place: so there are few, and none stays long.
class WaitingRoom {
 public:
  explicit WaitingRoom(std::size_t places, core::Duration patience = core::Duration::max())
      : places_(places), patience_(patience) {}

  /// `stream` waits from `now` on. If every place was taken, the stream that waited longest loses
  /// its own and is returned: streams that never open do not keep out one that opens at once.
  [[nodiscard]] std::shared_ptr<OpenStream> enter(const std::shared_ptr<OpenStream>& stream,
                                                  core::TimePoint now);
  /// Its first message came, or it ended. False if it was not waiting any more.
  [[nodiscard]] bool leave(const OpenStream& stream);
  /// Those who have waited for `patience`; they have left.
  [[nodiscard]] std::vector<std::shared_ptr<OpenStream>> overdue(core::TimePoint now);

  [[nodiscard]] std::size_t waiting() const;
  [[nodiscard]] std::size_t places() const noexcept { return places_; }
  [[nodiscard]] core::Duration patience() const noexcept { return patience_; }

 private:
  struct Guest {
    const OpenStream* name{nullptr};
    std::weak_ptr<OpenStream> stream{};
    core::TimePoint since{};
  };

  const std::size_t places_;
  const core::Duration patience_;
  mutable std::mutex mutex_;
  std::deque<Guest> guests_{};  ///< in the order in which they came
};

/// A stream as the server's shutdown sees it.
class OpenStream {
 public:
  explicit OpenStream(OpenStreams& streams);
  virtual ~OpenStream();
  OpenStream(const OpenStream&) = delete;
  OpenStream& operator=(const OpenStream&) = delete;
  /// Ends the stream with UNAVAILABLE; any thread, idempotent.
  virtual void server_closes() = 0;
  /// The session `session_id` goes on with another stream: if it is this one's, this one ends.
  virtual void goes_on_elsewhere(const std::string& session_id) { static_cast<void>(session_id); }
  /// The stream has to end: a session has no place, or was never opened.
  virtual void end_with(const Refusal& why) { static_cast<void>(why); }
  /// Adds what is known of the links of this stream, if it is a session on `device` (empty: any).
  virtual void report(const std::string& device, v1::GetLinkStatsResponse& response) {
    static_cast<void>(device);
    static_cast<void>(response);
  }

 private:
  OpenStreams& streams_;
};

class ServiceContext final : public Front {
 public:
  ServiceContext(FrontConfig front_config, OwnerPort& owner, FactsProvider facts_provider,
                 ServiceLimits service_limits = {});

  /// Account of the connection of a call that stays for a while, by its peer's name (Connections).
  [[nodiscard]] std::shared_ptr<Account> account_of(const std::string& peer);
  [[nodiscard]] double loop_hz() const { return 1.0 / core::seconds(config.period); }
  [[nodiscard]] SessionSettings session_settings(Carrier stream) const {
    return {loop_hz(), limits.clock, limits.age_by_source_time, stream};
  }
  /// Session streams that are open.
  [[nodiscard]] unsigned sessions() const;

  /// Ends the streams that waited too long for their first message. Any thread.
  void end_overdue(core::TimePoint now);

  /// True if a device is served: open, and its loop on time (proto/README.md, "Conventions").
  [[nodiscard]] bool serving(std::size_t device) const;
  /// All of them.
  [[nodiscard]] bool serving() const;

  const FrontConfig config;
  const ServiceLimits limits;
  const FactsProvider server_facts;
  OpenStreams streams;
  WaitingRoom waiting;  ///< session streams whose first message has not come
  /// Sessions whose lease has ended, which look on without having come as observers. They leave
  /// places to those who come for a lease.
  WaitingRoom former;
  std::unique_ptr<Connections> connections;                ///< null before start()
  std::unique_ptr<UdpPort> udp;                            ///< null if the scene has no udp_listen
  std::vector<std::shared_ptr<Broadcaster>> broadcasters;  ///< per device, each told by the owner
};

}  // namespace haptic::server
