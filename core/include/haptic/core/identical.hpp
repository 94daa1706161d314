#pragma once
/// Equality to the bit: a NaN equals itself, 0.0 and -0.0 differ. The test of replay
/// (CONTRIBUTING.md#one-tick-is-a-pure-function). A struct takes part by its function members(),
/// which lists all its members.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace haptic::core {

template <typename T>
[[nodiscard]] bool identical(const T& a, const T& b) noexcept {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  } else if constexpr (requires { a.members(); }) {
    const auto of_a = a.members(), of_b = b.members();
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      return (identical(std::get<I>(of_a), std::get<I>(of_b)) && ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(of_a)>>{});
  } else if constexpr (requires { a.cols(); }) {  // a vector or matrix of Eigen
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           std::equal(a.data(), a.data() + a.size(), b.data(), identical<double>);
  } else if constexpr (requires { a.begin(); }) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), identical<typename T::value_type>);
  } else {
    return a == b;
  }
}

}  // namespace haptic::core
