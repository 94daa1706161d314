#pragma once
/// Keeps the standard health service true: overall "" and one entry per device (private to
/// server/rpc).

#include <grpcpp/health_check_service_interface.h>

#include <chrono>
#include <memory>

#include "server/crossing/ports.hpp"
#include "server/rpc/every.hpp"

namespace haptic::server {

/// SERVING while the device is open and the loop on time: a record within kSilence, a state other
/// than INIT and CLOSING, and no fault of the device's link or of the loop. Looks by itself four
/// times a second, so that a loop that has stopped is noticed too.
class HealthKeeper {
 public:
  static constexpr std::chrono::milliseconds kEvery{250};
  static constexpr std::chrono::milliseconds kSilence{500};

  HealthKeeper(grpc::HealthCheckServiceInterface& health, const OwnerPort& owner);
  /// Waits for the last look; everything is NOT_SERVING then.
  ~HealthKeeper();
  HealthKeeper(const HealthKeeper&) = delete;
  HealthKeeper& operator=(const HealthKeeper&) = delete;

 private:
  void look();

  grpc::HealthCheckServiceInterface& health_;
  const OwnerPort& owner_;
  std::unique_ptr<Every> looks_;
};

}  // namespace haptic::server
