#include "server/front/session/refusals.hpp"

#include <cmath>

#include "haptic/wire/printable.hpp"

namespace haptic::server {

std::optional<Refusal> too_large(std::size_t bytes) {
  if (bytes <= kLargestMessage) return std::nullopt;
  return limit_reached("MESSAGE_TOO_LARGE",
                       "message of " + std::to_string(bytes) + " bytes: at most " +
                           std::to_string(kLargestMessage) + " are taken",
                       kLargestMessage);
}

Refusal observes_only() {
  return {Refusal::Code::kPermission, "RIGHTS",
          "this token is for observers: it allows to look on and to stop, and nothing else"};
}

std::string sanitised(const std::string& text, std::size_t longest) {
  std::size_t size = text.size();
  if (size > longest) {
    size = longest;
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0U) == 0x80U) --size;
  }
  const std::string_view kept(text.data(), size);
  std::string clean;
  for (std::size_t i = 0; i < size;) {
    const wire::Character next = wire::character(kept, i);
    clean += next.shows_itself ? kept.substr(i, next.bytes) : "?";
    i += next.bytes;
  }
  return clean;
}

std::optional<Refusal> check_rate(const char* field, double rate_hz, double loop_hz) {
  // A loop of 1 ms is 1000 Hz in words and 999.99... in doubles.
  const double most = std::round(loop_hz);
  if (rate_hz == 0.0 || (rate_hz >= 1.0 && rate_hz <= most)) return std::nullopt;
  return invalid_field(field, "= " + std::to_string(rate_hz) + ": must be 0, or 1.." +
                                  std::to_string(static_cast<int>(most)) + " Hz");
}

}  // namespace haptic::server
