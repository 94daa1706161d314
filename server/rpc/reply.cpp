#include "server/rpc/reply.hpp"

#include <utility>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace haptic::server {

grpc::Status to_status(const Refusal& refusal) {
  const auto code = static_cast<grpc::StatusCode>(refusal.code);
  google::rpc::Status status;
  status.set_code(code);
  status.set_message(refusal.message.str());
  google::rpc::ErrorInfo info;
  info.set_reason(refusal.reason.str());
  info.set_domain("hapticd");
  for (const auto& [name, value] : refusal.details) {
    if (!name.empty()) (*info.mutable_metadata())[name.str()] = value.str();
  }
  status.add_details()->PackFrom(info);
  if (!refusal.field.empty()) {
    google::rpc::BadRequest bad;
    auto* violation = bad.add_field_violations();
    violation->set_field(refusal.field.str());
    violation->set_description(refusal.message.str());
    status.add_details()->PackFrom(bad);
  }
  return {code, refusal.message.str(), status.SerializeAsString()};
}

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
