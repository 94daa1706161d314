#pragma once
/// What states say beside the device's own, where its scene asks for it: the certificate of the linearised
/// method, and a metric for the client's own projection.

#include <cstdint>
#include <vector>

namespace haptic::client {

/// The certificate of the linearised method (session.proto, CertificateState).
struct CertificateState {
  enum class Status : std::uint8_t {
    kUnknown = 0,
    kComputed = 1,
    kIdle = 2,
    kOtherRenderer = 3,
    kMapFailed = 4,
    kNotFullRank = 5,
    kNoStiffness = 6,
  };
  Status status{Status::kUnknown};
  double margin{0.0};  ///< while kComputed
  unsigned block{0};
};
[[nodiscard]] const char* name(CertificateState::Status status) noexcept;  ///< "COMPUTED"

/// A metric for the client's own projection (session.proto, CouplingBlock).
struct CouplingBlock {
  unsigned coordinates{0};      ///< n
  std::vector<double> lower{};  ///< of the n x n matrix, row by row; empty: none here
};

}  // namespace haptic::client
