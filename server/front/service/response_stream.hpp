#pragma once
/// Common part of every stream of responses, whatever carries it: one write at a time, and an end
/// that happens once, whatever its cause. A carrier (grpc/, web/) derives from it.

#include <memory>
#include <mutex>
#include <optional>

#include "server/front/service/service_context.hpp"
#include "server/front/service/state_frame.hpp"

namespace haptic::server {

class ResponseStream : public Subscriber,
                       public OpenStream,
                       public std::enable_shared_from_this<ResponseStream> {
 public:
  explicit ResponseStream(ServiceContext& context, std::shared_ptr<Account> account = nullptr)
      : OpenStream(context.streams), context_(context), booked_(std::move(account)) {}

  void server_closes() override {
    end(Refusal{Refusal::Code::kUnavailable, "CLOSING", "the server is shutting down"});
  }

 protected:
  enum class Ending : std::uint8_t {
    kGivenUp,  ///< on purpose, by either end
    kLost,     ///< the stream broke: a resumable session may come back
  };

  // Calls to the carrier.
  /// Under the mutex; no other write is under way. Sets writing_; written() follows, later.
  virtual void write(Outgoing message) = 0;
  /// Once, with no write under way. Absent: the stream ended in order, or is broken.
  virtual void finish(const std::optional<Refusal>& why) = 0;

  // Calls by the carrier.
  void written(bool ok);
  /// The far end half-closed, or is gone.
  void lost() { end({}, Ending::kLost); }

  /// Under the mutex: starts the next write that is not a state, if none is under way.
  virtual void flush() = 0;
  /// Gives up what the stream holds at the owner. Not under the mutex.
  virtual void close(Ending ending) = 0;

  void end(const std::optional<Refusal>& why, Ending ending = Ending::kGivenUp);
  /// From now on offered states by `broadcaster`; as Broadcaster::add().
  void join(Broadcaster& broadcaster, std::uint32_t tenure = 0);

  ServiceContext& context_;
  std::mutex mutex_;
  bool ended_{false};
  bool given_up_{false};  ///< close() has run: the client may now be told of the end
  bool writing_{false};

 private:
  void leave();

  const BookedCall booked_;
  Broadcaster* broadcaster_{nullptr};
  std::optional<Refusal> why_{};  ///< it ended
};

}  // namespace haptic::server
