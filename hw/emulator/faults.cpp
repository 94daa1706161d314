#include "hw/emulator/faults.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <random>
#include <string_view>

#include "haptic/core/error.hpp"
#include "hw/random.hpp"

namespace haptic::hw::emulator {
namespace {

struct Entry {
  FaultKind kind{};
  std::string_view name{};
};
constexpr std::array<Entry, 6> kKinds{{{FaultKind::kStall, "stall"},
                                       {FaultKind::kBrownOut, "brown-out"},
                                       {FaultKind::kUnplug, "unplug"},
                                       {FaultKind::kStuck, "stuck"},
                                       {FaultKind::kDrift, "drift"},
                                       {FaultKind::kHang, "hang"}}};
constexpr double kDriftRate = 1e-4;  // m/s, if none is given

[[noreturn]] void refuse(const std::string& text) {
  throw core::DeviceError("fault '" + text +
                          "': must be KIND@START[+LENGTH][=AMOUNT] in seconds, KIND one of stall, "
                          "brown-out, unplug, stuck, drift, hang");
}

/// The number between `from` and `to` of `text`, not negative.
double number(const std::string& text, std::size_t from, std::size_t to) {
  double value = -1.0;
  const char* const end = text.data() + to;
  const auto result = std::from_chars(text.data() + from, end, value);
  if (result.ec != std::errc{} || result.ptr != end || !(value >= 0.0)) refuse(text);
  return value;
}

}  // namespace

std::string name(FaultKind kind) {
  return std::string(kKinds.at(static_cast<std::size_t>(kind)).name);
}

FaultSpec parse_fault(const std::string& text) {
  const std::size_t at = text.find('@');
  if (at == std::string::npos) refuse(text);
  const auto* const entry = std::find_if(kKinds.begin(), kKinds.end(), [&](const Entry& e) {
    return e.name == std::string_view(text).substr(0, at);
  });
  if (entry == kKinds.end()) refuse(text);
  FaultSpec fault;
  fault.kind = entry->kind;
  const std::size_t amount_at = std::min(text.find('=', at), text.size());
  const std::size_t length_at = std::min(text.find('+', at), amount_at);
  fault.at = number(text, at + 1, length_at);
  if (length_at < amount_at) fault.length = number(text, length_at + 1, amount_at);
  if (fault.kind == FaultKind::kDrift) fault.amount = kDriftRate;
  if (amount_at < text.size()) fault.amount = number(text, amount_at + 1, text.size());
  return fault;
}

std::vector<FaultSpec> draw_faults(std::uint64_t seed, int count, double seconds) {
  std::mt19937_64 random(seed);
  std::vector<FaultSpec> faults;
  for (int i = 0; i < count; ++i) {
    FaultSpec fault;
    fault.kind = kKinds.at(random() % kKinds.size()).kind;
    fault.at = seconds * uniform(random);
    fault.length = 0.2 + 1.8 * uniform(random);
    if (fault.kind == FaultKind::kDrift) fault.amount = kDriftRate;
    faults.push_back(fault);
  }
  std::sort(faults.begin(), faults.end(),
            [](const FaultSpec& a, const FaultSpec& b) { return a.at < b.at; });
  return faults;
}

}  // namespace haptic::hw::emulator
