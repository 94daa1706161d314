#pragma once
/// What the certificate of the linearised method says of one tick (linear_certificate.hpp,
/// core/METHOD.md#exact-derivatives).

#include <cstdint>
#include <string_view>
#include <tuple>

namespace haptic::core {

enum class CertificateStatus : std::uint8_t {
  kOff = 0,            ///< the scene does not ask for it
  kComputed = 1,       ///< the only one with a margin
  kIdle = 2,           ///< no proxy, or none that is displaced: nothing pulls
  kOtherRenderer = 3,  ///< another one than Eq. (8) renders
  kMapFailed = 4,      ///< f or dJ/dq has no value at q
  kNotFullRank = 5,    ///< J of `block` has not full column rank (condition above 1e8)
  kNoStiffness = 6,    ///< an actuator of `block` has stiffness 0: nothing to compare with
};

[[nodiscard]] std::string_view name(CertificateStatus status) noexcept;  ///< "COMPUTED", ...

struct Certificate {
  CertificateStatus status{CertificateStatus::kOff};
  /// Index in Kinematics::blocks(), 0 for a map without blocks: the block with the least margin, or
  /// the one that has none.
  int block{0};
  double margin{0.0};  ///< the least of the displaced blocks'

  [[nodiscard]] auto members() const noexcept { return std::tie(status, block, margin); }
};

}  // namespace haptic::core
