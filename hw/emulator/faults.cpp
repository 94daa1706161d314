#include "hw/emulator/faults.hpp"

#include <algorithm>
#include <array>
#include <regex>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

/// In the order of FaultKind.
constexpr std::array kNames{"stall", "brown-out", "unplug", "stuck", "drift", "hang"};
constexpr double kDriftRate = 1e-4;  // m/s, if none is given

}  // namespace

FaultSpec parse_fault(const std::string& text) {
  const std::string number = R"(([0-9]*\.?[0-9]+(?:e-?[0-9]{1,2})?))";
  const std::regex form("([a-z-]+)@" + number + "(?:\\+" + number + ")?(?:=" + number + ")?");
  std::smatch match;
  const bool read = std::regex_match(text, match, form);
  const auto* const kind = std::find(kNames.begin(), kNames.end(), read ? match.str(1) : "");
  if (kind == kNames.end()) {
    throw core::DeviceError("fault '" + text +
                            "': must be KIND@START[+LENGTH][=AMOUNT] in seconds, KIND one of "
                            "stall, brown-out, unplug, stuck, drift, hang");
  }
  FaultSpec fault;
  fault.kind = static_cast<FaultKind>(kind - kNames.begin());
  fault.at = std::stod(match.str(2));
  if (match[3].matched) fault.length = std::stod(match.str(3));
  if (fault.kind == FaultKind::kDrift) fault.amount = kDriftRate;
  if (match[4].matched) fault.amount = std::stod(match.str(4));
  return fault;
}

}  // namespace haptic::hw::emulator
