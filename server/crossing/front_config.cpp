#include "server/crossing/front_config.hpp"

#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/crossing/fields.hpp"

namespace haptic::server {
namespace {

/// The last value of an enum; the first is 0 or 1.
template <typename Enum>
constexpr Enum kLast{};
template <>
constexpr auto kLast<FrontConfig::Use> = FrontConfig::Use::kMetrics;
template <>
constexpr auto kLast<Protection> = Protection::kInsecureLab;
template <>
constexpr auto kLast<Priority> = Priority::kOperator;

/// Walks through a configuration, and either writes it or reads it.
class Walk {
 public:
  /// Appends to `bytes`.
  explicit Walk(std::string& bytes) : written_(&bytes) {}
  explicit Walk(std::string_view bytes) : left_(bytes) {}

  void pass(std::string& text) {
    const std::uint64_t size = this->size(text.size());
    if (written_ != nullptr) {
      *written_ += text;
      return;
    }
    text = left_.substr(0, size);
    left_.remove_prefix(size);
  }
  void pass(std::filesystem::path& path) {
    std::string text = path.string();
    pass(text);
    path = text;
  }
  void pass(core::Duration& time) {
    time =
        core::Duration(static_cast<std::int64_t>(number(static_cast<std::uint64_t>(time.count()))));
  }
  template <typename T>
  void pass(std::vector<T>& list) {
    const std::uint64_t size = this->size(list.size());
    for (std::uint64_t i = 0; i < size; ++i) {
      inside("[" + std::to_string(i) + "]", i < list.size() ? list[i] : list.emplace_back());
    }
  }
  template <typename T>
  void pass(std::optional<T>& value) {
    if (number(value.has_value() ? 1 : 0, 1) == 0) return;
    pass(value ? *value : value.emplace());
  }
  template <typename T>
  void pass(T& value) {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(
          number(static_cast<std::uint64_t>(value), static_cast<std::uint64_t>(kLast<T>)));
    } else if constexpr (std::is_integral_v<T>) {
      value = static_cast<T>(number(value, std::numeric_limits<T>::max()));
    } else {
      for_each_field(value, [this](std::string_view name, auto& field) {
        inside((field_.empty() ? "" : ".") + std::string(name), field);
      });
    }
  }
  void end() {
    if (!left_.empty()) refuse(std::to_string(left_.size()) + " bytes follow");
  }

 private:
  template <typename T>
  void inside(const std::string& name, T& value) {
    field_ += name;
    pass(value);
    field_.resize(field_.size() - name.size());
  }
  /// The number that is written, or the one that was read.
  std::uint64_t number(std::uint64_t value, std::uint64_t most = ~std::uint64_t{0}) {
    if (written_ != nullptr) {
      written_->append(reinterpret_cast<const char*>(&value), sizeof value);
      return value;
    }
    if (left_.size() < sizeof value) refuse("ends too early");
    std::memcpy(&value, left_.data(), sizeof value);
    left_.remove_prefix(sizeof value);
    return up_to(most, value);
  }
  /// How many bytes or entries follow. An entry has at least one byte.
  std::uint64_t size(std::uint64_t value) {
    value = number(value);
    return written_ != nullptr ? value : up_to(left_.size(), value);
  }
  [[nodiscard]] std::uint64_t up_to(std::uint64_t most, std::uint64_t value) const {
    if (value <= most) return value;
    refuse(std::to_string(value) + ": must be at most " + std::to_string(most));
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw core::TransportError("front configuration: " + field_ + (field_.empty() ? "" : ": ") +
                               why);
  }

  std::string* written_{nullptr};  ///< null: it reads
  std::string_view left_{};
  std::string field_{};
};

}  // namespace

std::string to_bytes(FrontConfig config) {
  std::string bytes;
  Walk(bytes).pass(config);
  return bytes;
}

FrontConfig front_config(std::string_view bytes) {
  Walk walk(bytes);
  FrontConfig config;
  walk.pass(config);
  walk.end();
  return config;
}

std::size_t sockets_of(const FrontConfig& config) {
  std::size_t all = config.udp_listen.empty() ? 0 : 1;
  for (const FrontConfig::Address& address : config.addresses) all += address.sockets;
  return all;
}

std::size_t files_of(const FrontConfig& config) {
  std::size_t all = config.web ? config.web->tokens.size() + 1 : 0;
  if (config.tls) all += config.tls->client_ca.empty() ? 2 : 3;
  return all;
}

}  // namespace haptic::server
