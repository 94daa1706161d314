#pragma once
/// Equality to the bit: a NaN equals itself, 0.0 and -0.0 differ. The test of replay
/// (CONTRIBUTING.md#one-tick-is-a-pure-function). A struct is compared member by member, without a
/// list of its members.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "haptic/core/contacts/proxy_snapshot.hpp"
#include "server/crossing/fields.hpp"

namespace haptic::core {

/// PlaneSet has a constructor.
[[nodiscard]] inline auto fields_of(const PlaneSet& p) noexcept {
  return std::tuple_cat(
      std::tie(p.normals, p.offsets, p.laws, p.ids, p.objects, p.curvature, p.first, p.curved),
      p.lists());
}

template <typename T>
[[nodiscard]] bool identical(const T& a, const T& b) noexcept {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  } else if constexpr (requires { a.cols(); }) {  // a vector or matrix of Eigen
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           std::equal(a.data(), a.data() + a.size(), b.data(), identical<double>);
  } else if constexpr (requires { a.begin(); }) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), identical<typename T::value_type>);
  } else if constexpr (std::is_aggregate_v<T> || std::is_same_v<T, PlaneSet>) {
    using server::fields_of;
    const auto of_a = fields_of(a), of_b = fields_of(b);
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      return (identical(std::get<I>(of_a), std::get<I>(of_b)) && ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(of_a)>>{});
  } else {
    return a == b;
  }
}

}  // namespace haptic::core
