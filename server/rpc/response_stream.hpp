#pragma once
/// What every stream of responses does alike (private to server/rpc): one write at a time, an end
/// that happens once, whatever its cause, and a life as long as gRPC or an answer needs it.

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <memory>
#include <mutex>
#include <utility>

#include "server/rpc/reply.hpp"
#include "server/rpc/service_context.hpp"

namespace haptic::server {

/// `Reactor`: gRPC's, writing ByteBuffers.
template <typename Reactor>
class ResponseStream : public Reactor,
                       public Subscriber,
                       public OpenStream,
                       public std::enable_shared_from_this<ResponseStream<Reactor>> {
 public:
  explicit ResponseStream(ServiceContext& context, std::shared_ptr<Account> account = nullptr)
      : OpenStream(context.streams), context_(context), booked_(std::move(account)) {}

  void server_closes() override {
    end(to_status({Refusal::Code::kUnavailable, "CLOSING", "the server is shutting down"}));
  }
  void OnCancel() override { end(grpc::Status::CANCELLED, Ending::kLost); }
  void OnWriteDone(bool ok) override;
  void OnDone() override { const auto last = std::move(self_); }

 protected:
  enum class Ending : std::uint8_t {
    kGivenUp,  ///< on purpose, by either end
    kLost,     ///< the stream broke: a resumable session may come back
  };
  /// Lives until gRPC is done with it.
  void keep_alive() { self_ = this->shared_from_this(); }
  /// Under the mutex: starts the next write that is not a state, if none is under way.
  virtual void flush() = 0;
  /// Under the mutex; no other write is under way.
  void write(grpc::ByteBuffer buffer);
  void end(const grpc::Status& status, Ending ending = Ending::kGivenUp);
  /// Gives up what the stream holds at the owner. Not under the mutex.
  virtual void close(Ending ending) = 0;
  /// From now on offered states by `broadcaster`; as Broadcaster::add().
  void join(Broadcaster& broadcaster, std::uint32_t tenure = 0);

  ServiceContext& context_;
  std::mutex mutex_;
  bool ended_{false};
  bool given_up_{false};  ///< what it held: from here on the client may hear of the end
  bool writing_{false};

 private:
  void leave();

  const BookedCall booked_;
  Broadcaster* broadcaster_{nullptr};
  std::shared_ptr<ResponseStream> self_;
  grpc::Status final_status_;
  grpc::ByteBuffer outgoing_;
};

template <typename Reactor>
void ResponseStream<Reactor>::write(grpc::ByteBuffer buffer) {
  writing_ = true;
  outgoing_.Swap(&buffer);
  this->StartWrite(&outgoing_);
}

template <typename Reactor>
void ResponseStream<Reactor>::OnWriteDone(bool ok) {
  bool finish = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    finish = given_up_;
    if (ok) flush();
  }
  if (finish) {
    this->Finish(final_status_);
  } else if (!ok) {
    end(grpc::Status::CANCELLED, Ending::kLost);
  }
}

template <typename Reactor>
void ResponseStream<Reactor>::end(const grpc::Status& status, Ending ending) {
  // Finish may be followed by OnDone before it returns here.
  const auto keep = this->shared_from_this();
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
    final_status_ = status;
  }
  // Before the client hears of the end: it may open its next session at once.
  close(ending);
  leave();
  bool finish = false;
  {
    const std::lock_guard lock(mutex_);
    given_up_ = true;
    finish = !writing_;  // else the write's own completion finishes
  }
  if (finish) this->Finish(status);
}

template <typename Reactor>
void ResponseStream<Reactor>::join(Broadcaster& broadcaster, std::uint32_t tenure) {
  broadcaster.add(this->shared_from_this(), tenure);
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    broadcaster_ = &broadcaster;
    ended = ended_;
  }
  if (ended) leave();  // its end may have come before it joined
}

template <typename Reactor>
void ResponseStream<Reactor>::leave() {
  Broadcaster* joined = nullptr;
  {
    const std::lock_guard lock(mutex_);
    joined = broadcaster_;
  }
  if (joined != nullptr) joined->remove(this);
}

}  // namespace haptic::server
