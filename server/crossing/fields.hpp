#pragma once
/// The fields of a struct with their names, taken from its declaration: of them layout.hpp makes
/// the number that two builds compare, and front_config.cpp the bytes for another process. A struct
/// must be an aggregate of up to 50 fields, each of which can be made from {}.

#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace haptic::server {

// 10 t + u values {} and names, with u in 1 ... 10 and t in 0 ... 4.
// clang-format off
#define HAPTIC_MADE_1 {}
#define HAPTIC_MADE_2 {}, {}
#define HAPTIC_MADE_3 {}, {}, {}
#define HAPTIC_MADE_4 {}, {}, {}, {}
#define HAPTIC_MADE_5 {}, {}, {}, {}, {}
#define HAPTIC_MADE_6 {}, {}, {}, {}, {}, {}
#define HAPTIC_MADE_7 {}, {}, {}, {}, {}, {}, {}
#define HAPTIC_MADE_8 {}, {}, {}, {}, {}, {}, {}, {}
#define HAPTIC_MADE_9 {}, {}, {}, {}, {}, {}, {}, {}, {}
#define HAPTIC_MADE_10 {}, {}, {}, {}, {}, {}, {}, {}, {}, {}
#define HAPTIC_NAMED_1(t) t##1
#define HAPTIC_NAMED_2(t) t##1, t##2
#define HAPTIC_NAMED_3(t) t##1, t##2, t##3
#define HAPTIC_NAMED_4(t) t##1, t##2, t##3, t##4
#define HAPTIC_NAMED_5(t) t##1, t##2, t##3, t##4, t##5
#define HAPTIC_NAMED_6(t) t##1, t##2, t##3, t##4, t##5, t##6
#define HAPTIC_NAMED_7(t) t##1, t##2, t##3, t##4, t##5, t##6, t##7
#define HAPTIC_NAMED_8(t) t##1, t##2, t##3, t##4, t##5, t##6, t##7, t##8
#define HAPTIC_NAMED_9(t) t##1, t##2, t##3, t##4, t##5, t##6, t##7, t##8, t##9
#define HAPTIC_NAMED_10(t) t##1, t##2, t##3, t##4, t##5, t##6, t##7, t##8, t##9, t##10
#define HAPTIC_TENS_MADE_0
#define HAPTIC_TENS_NAMED_0
#define HAPTIC_TENS_MADE_1 HAPTIC_TENS_MADE_0 HAPTIC_MADE_10,
#define HAPTIC_TENS_NAMED_1 HAPTIC_TENS_NAMED_0 HAPTIC_NAMED_10(a),
#define HAPTIC_TENS_MADE_2 HAPTIC_TENS_MADE_1 HAPTIC_MADE_10,
#define HAPTIC_TENS_NAMED_2 HAPTIC_TENS_NAMED_1 HAPTIC_NAMED_10(b),
#define HAPTIC_TENS_MADE_3 HAPTIC_TENS_MADE_2 HAPTIC_MADE_10,
#define HAPTIC_TENS_NAMED_3 HAPTIC_TENS_NAMED_2 HAPTIC_NAMED_10(c),
#define HAPTIC_TENS_MADE_4 HAPTIC_TENS_MADE_3 HAPTIC_MADE_10,
#define HAPTIC_TENS_NAMED_4 HAPTIC_TENS_NAMED_3 HAPTIC_NAMED_10(d),
#define HAPTIC_TIE(t, u)                                                           \
  if constexpr (requires { Struct{HAPTIC_TENS_MADE_##t HAPTIC_MADE_##u}; }) {      \
    auto& [HAPTIC_TENS_NAMED_##t HAPTIC_NAMED_##u(x)] = value;                     \
    return std::tie(HAPTIC_TENS_NAMED_##t HAPTIC_NAMED_##u(x));                    \
  } else  // NOLINT(readability-else-after-return)

/// References to the fields, in their order.
template <typename T>
constexpr auto fields_of(T& value) noexcept {
  using Struct = std::remove_const_t<T>;
  HAPTIC_TIE(4, 10) HAPTIC_TIE(4, 9) HAPTIC_TIE(4, 8) HAPTIC_TIE(4, 7) HAPTIC_TIE(4, 6)
  HAPTIC_TIE(4, 5) HAPTIC_TIE(4, 4) HAPTIC_TIE(4, 3) HAPTIC_TIE(4, 2) HAPTIC_TIE(4, 1)
  HAPTIC_TIE(3, 10) HAPTIC_TIE(3, 9) HAPTIC_TIE(3, 8) HAPTIC_TIE(3, 7) HAPTIC_TIE(3, 6)
  HAPTIC_TIE(3, 5) HAPTIC_TIE(3, 4) HAPTIC_TIE(3, 3) HAPTIC_TIE(3, 2) HAPTIC_TIE(3, 1)
  HAPTIC_TIE(2, 10) HAPTIC_TIE(2, 9) HAPTIC_TIE(2, 8) HAPTIC_TIE(2, 7) HAPTIC_TIE(2, 6)
  HAPTIC_TIE(2, 5) HAPTIC_TIE(2, 4) HAPTIC_TIE(2, 3) HAPTIC_TIE(2, 2) HAPTIC_TIE(2, 1)
  HAPTIC_TIE(1, 10) HAPTIC_TIE(1, 9) HAPTIC_TIE(1, 8) HAPTIC_TIE(1, 7) HAPTIC_TIE(1, 6)
  HAPTIC_TIE(1, 5) HAPTIC_TIE(1, 4) HAPTIC_TIE(1, 3) HAPTIC_TIE(1, 2) HAPTIC_TIE(1, 1)
  HAPTIC_TIE(0, 10) HAPTIC_TIE(0, 9) HAPTIC_TIE(0, 8) HAPTIC_TIE(0, 7) HAPTIC_TIE(0, 6)
  HAPTIC_TIE(0, 5) HAPTIC_TIE(0, 4) HAPTIC_TIE(0, 3) HAPTIC_TIE(0, 2) HAPTIC_TIE(0, 1)
  static_assert(std::is_empty_v<Struct>, "not an aggregate");
}
// clang-format on

/// The compiler's spelling of a type. Two compilers need not agree.
template <typename T>
consteval std::string_view type_name() noexcept {
  return __PRETTY_FUNCTION__;
}

namespace named {

template <typename T>
struct Somewhere {
  T value;
};
/// Never defined: only the addresses of its fields are named.
template <typename T>
extern const Somewhere<T> kSomewhere;

template <typename T>
struct Address {
  const T* of;
};
template <typename T>
Address(const T*) -> Address<T>;

template <auto address>
consteval std::string_view spelled() noexcept {
  return __PRETTY_FUNCTION__;
}

}  // namespace named

#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wundefined-var-template"
#endif
/// The name of a field, as it is declared.
template <typename T, std::size_t index>
consteval std::string_view field_name() noexcept {
  // "... address = {(& kSomewhere<S>.Somewhere<S>::value.S::gain)}", or "...value.gain}" (clang).
  std::string_view name =
      named::spelled<named::Address{&std::get<index>(fields_of(named::kSomewhere<T>.value))}>();
  name = name.substr(0, name.rfind('}'));
  if (name.ends_with(')')) name.remove_suffix(1);
  return name.substr(name.find_last_of(":.") + 1);
}
#if defined(__clang__)
#pragma clang diagnostic pop
#endif

/// The name of a value of an enumeration, without that of its type; of one without a name a number.
template <auto value>
consteval std::string_view value_name() noexcept {
  // "... address = S::kStop]", or "... address = (S)7]".
  std::string_view name = named::spelled<value>();
  if (const std::size_t end = name.rfind(';'); end != std::string_view::npos) {
    name = name.substr(0, end);  // gcc goes on with "; std::string_view = ..."
  }
  name = name.substr(0, name.rfind(']'));
  return name.substr(name.find_last_of(":)") + 1);
}

/// Calls visit(name, field) for each field of `value`, in their order.
template <typename T, typename Visit>
constexpr void for_each_field(T& value, Visit&& visit) {
  const auto fields = fields_of(value);
  [&]<std::size_t... index>(std::index_sequence<index...>) {
    (visit(field_name<std::remove_const_t<T>, index>(), std::get<index>(fields)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<decltype(fields_of(value))>>());
}

}  // namespace haptic::server
