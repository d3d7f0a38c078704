#pragma once
// The name of a value of an enumeration, from a table with one name for each value up to `last`, in their order.

#include <cstddef>
#include <string_view>

namespace forefeel {

template <auto last>
constexpr std::string_view name_in(const std::string_view (&names)[static_cast<std::size_t>(last) + 1],
                                   decltype(last) value) {
  return value <= last ? names[static_cast<std::size_t>(value)] : "";
}

}  // namespace forefeel
