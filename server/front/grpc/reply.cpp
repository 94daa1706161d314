#include "server/front/grpc/reply.hpp"

#include <array>
#include <memory>
#include <utility>

#include "server/front/service/rich_status.hpp"

namespace haptic::server {

grpc::Status to_status(const std::optional<Refusal>& refusal) {
  if (!refusal) return grpc::Status::OK;
  return {static_cast<grpc::StatusCode>(refusal->code), refusal->message.str(),
          rich_status(*refusal).SerializeAsString()};
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

}  // namespace haptic::server
