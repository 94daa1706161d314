#include "server/front/service/rich_status.hpp"

#include "google/rpc/error_details.pb.h"

namespace haptic::server {

google::rpc::Status rich_status(const Refusal& refusal) {
  google::rpc::Status status;
  status.set_code(static_cast<int>(refusal.code));
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
  return status;
}

}  // namespace haptic::server
