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

class Writer {
 public:
  void write(const std::string& text) {
    number(text.size());
    bytes_ += text;
  }
  void write(const std::filesystem::path& path) { write(path.string()); }
  void write(core::Duration time) { number(static_cast<std::uint64_t>(time.count())); }
  template <typename T>
  void write(const std::vector<T>& list) {
    number(list.size());
    for (const T& each : list) write(each);
  }
  template <typename T>
  void write(const std::optional<T>& value) {
    number(value.has_value() ? 1 : 0);
    if (value) write(*value);
  }
  template <typename T>
  void write(const T& value) {
    if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
      number(static_cast<std::uint64_t>(value));
    } else {
      for_each_field(value, [this](std::string_view, const auto& field) { write(field); });
    }
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  void number(std::uint64_t value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }

  std::string bytes_{};
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  void read(std::string& text) {
    const std::uint64_t size = up_to(left_.size());
    text = left_.substr(0, size);
    left_.remove_prefix(size);
  }
  void read(std::filesystem::path& path) {
    std::string text;
    read(text);
    path = text;
  }
  void read(core::Duration& time) { time = core::Duration(static_cast<std::int64_t>(number())); }
  template <typename T>
  void read(std::vector<T>& list) {
    const std::uint64_t size = up_to(left_.size());
    for (std::uint64_t i = 0; i < size; ++i) {
      inside("[" + std::to_string(i) + "]", list.emplace_back());
    }
  }
  template <typename T>
  void read(std::optional<T>& value) {
    if (up_to(1) != 0) read(value.emplace());
  }
  template <typename T>
  void read(T& value) {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(up_to(static_cast<std::uint64_t>(kLast<T>)));
    } else if constexpr (std::is_integral_v<T>) {
      value = static_cast<T>(up_to(std::numeric_limits<T>::max()));
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
    read(value);
    field_.resize(field_.size() - name.size());
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    if (left_.size() < sizeof value) refuse("ends too early");
    std::memcpy(&value, left_.data(), sizeof value);
    left_.remove_prefix(sizeof value);
    return value;
  }
  std::uint64_t up_to(std::uint64_t most) {
    const std::uint64_t value = number();
    if (value <= most) return value;
    refuse(std::to_string(value) + ": must be at most " + std::to_string(most));
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw core::TransportError("front configuration: " + field_ + (field_.empty() ? "" : ": ") +
                               why);
  }

  std::string_view left_;
  std::string field_{};
};

}  // namespace

std::string to_bytes(const FrontConfig& config) {
  Writer writer;
  writer.write(config);
  return writer.take();
}

FrontConfig front_config(std::string_view bytes) {
  Reader reader(bytes);
  FrontConfig config;
  reader.read(config);
  reader.end();
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
