#include "server/rpc/tick_reply.hpp"

#include <utility>

#include "server/rpc/status.hpp"

namespace haptic::server {

void TickReply::watch(std::function<void()> give_up) {
  const std::lock_guard lock(mutex_);
  if (finished_) return;
  alarm_ = std::make_unique<grpc::Alarm>();
  // The alarm keeps the reply alive until it rang or was cancelled, and lets go of everything then:
  // its callback object lives as long as the alarm itself, which is the reply's.
  alarm_->Set(std::chrono::system_clock::now() + kPatience,
              [self = shared_from_this(), give_up = std::move(give_up)](bool rang) mutable {
                if (rang) {
                  give_up();
                  self->finish(to_status({Refusal::Code::kUnavailable, "NO_ANSWER",
                                          "the loop gave no answer within 500 ms"}));
                }
                give_up = nullptr;
                self.reset();
              });
}

void TickReply::finish(const grpc::Status& status, const std::function<void()>& fill) {
  if (finished_.exchange(true)) return;
  if (fill) fill();
  reactor_->Finish(status);
  const std::lock_guard lock(mutex_);
  if (alarm_) alarm_->Cancel();
}

}  // namespace haptic::server
