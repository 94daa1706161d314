#pragma once
/// The fake server's two streams. Every member is called with the server's mutex held, or takes it.

#include <deque>
#include <optional>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {

/// Common part of both kinds: messages go out one at a time, the end comes after the last of them.
template <typename Reactor, typename Message>
class Outbox : public Reactor {
 public:
  explicit Outbox(std::recursive_mutex& mutex) : mutex_(mutex) {}

  void send(const Message& message) {
    outbox_.push_back(message);
    go_on();
  }
  void end(const grpc::Status& status) {
    end_ = status;
    go_on();
  }

 protected:
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) outbox_.clear();
    go_on();
  }
  void OnCancel() override {
    const std::lock_guard lock(mutex_);
    outbox_.clear();
    end_ = grpc::Status::CANCELLED;
    if (!finished_) {
      finished_ = true;
      this->Finish(*end_);
    }
  }

 private:
  void go_on() {
    if (writing_ || finished_) return;
    if (!outbox_.empty()) {
      current_ = std::move(outbox_.front());
      outbox_.pop_front();
      writing_ = true;
      this->StartWrite(&current_);
    } else if (end_) {
      finished_ = true;
      this->Finish(*end_);
    }
  }

  std::recursive_mutex& mutex_;
  std::deque<Message> outbox_;
  Message current_;
  std::optional<grpc::Status> end_;
  bool writing_{false};
  bool finished_{false};
};

class FakeServer::SessionReactor final
    : public Outbox<grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>,
                    v1::SessionResponse> {
 public:
  explicit SessionReactor(FakeServer& server) : Outbox(server.mutex_), server_(server) {
    StartRead(&request_);
  }
  void read_on() {
    if (std::exchange(paused_, false)) StartRead(&request_);
  }

 private:
  void OnReadDone(bool ok) override;
  void OnDone() override;
  void open();

  FakeServer& server_;
  v1::SessionRequest request_;
  bool paused_{false};
};

class FakeServer::WatchReactor final
    : public Outbox<grpc::ServerWriteReactor<v1::WatchResponse>, v1::WatchResponse> {
 public:
  explicit WatchReactor(FakeServer& server) : Outbox(server.mutex_), server_(server) {}

 private:
  void OnDone() override;
  FakeServer& server_;
};

}  // namespace haptic::test
