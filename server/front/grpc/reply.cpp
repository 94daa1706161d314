#include "server/front/grpc/reply.hpp"

#include <array>
#include <chrono>
#include <utility>

#include "server/front/service/rich_status.hpp"

namespace haptic::server {

grpc::Status to_status(const Refusal& refusal) {
  return {static_cast<grpc::StatusCode>(refusal.code), refusal.message.str(),
          rich_status(refusal).SerializeAsString()};
}

grpc::ByteBuffer to_buffer(Outgoing message) {
  std::array<grpc::Slice, 3> slices;
  std::size_t n = 0;
  const auto add = [&](const std::string& part) {
    if (!part.empty()) slices[n++] = grpc::Slice(part);
  };
  add(message.head);
  if (message.shared) {
    using Shared = std::shared_ptr<const std::string>;
    auto* const keep = new Shared(std::move(message.shared));
    slices[n++] = grpc::Slice(
        const_cast<char*>((*keep)->data()), (*keep)->size(),
        [](void* kept) { delete static_cast<Shared*>(kept); }, keep);
  }
  add(message.tail);
  return {slices.data(), n};
}

void GrpcReply::watch(std::function<void()> give_up) {
  const std::lock_guard lock(mutex_);
  if (finished()) return;
  alarm_ = std::make_unique<grpc::Alarm>();
  // The alarm keeps the reply alive until it rang or was cancelled, and lets go of everything then:
  // its callback object lives as long as the alarm itself, which is the reply's.
  alarm_->Set(std::chrono::system_clock::now() + kPatience,
              [self = shared_from_this(), this, give_up = std::move(give_up)](bool rang) mutable {
                if (rang) time_is_up(give_up);
                give_up = nullptr;
                self.reset();
              });
}

void GrpcReply::send(const std::optional<Refusal>& why) {
  reactor_->Finish(why ? to_status(*why) : grpc::Status::OK);
  const std::lock_guard lock(mutex_);
  if (alarm_) alarm_->Cancel();
}

}  // namespace haptic::server
