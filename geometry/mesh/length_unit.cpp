#include "geometry/mesh/length_unit.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

constexpr std::array<std::pair<std::string_view, double>, 5> units{
    {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}}};
// Other spellings of their prefixes, before "m", "meter" or "metre"; the sign of micro is U+00B5, U+03BC or Latin-1.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> prefixes{{{"", "m"},
                                                                                 {"centi", "cm"},
                                                                                 {"milli", "mm"},
                                                                                 {"micro", "um"},
                                                                                 {"\xC2\xB5", "um"},
                                                                                 {"\xCE\xBC", "um"},
                                                                                 {"\xB5", "um"},
                                                                                 {"nano", "nm"}}};
constexpr double shortest_likely = 5e-3, longest_likely = 5;        // where no other unit is suggested [m]
constexpr double shortest_suggested = 5e-3, longest_suggested = 2;  // longest side of an organ or limb [m]

}  // namespace

std::optional<double> unit_of(std::string_view word) {
  std::string name = lower_case(word);
  if (name == "micron" || name == "microns") name = "um";
  if (name.size() > 3 && name.ends_with('s')) name.pop_back();
  for (const std::string_view metre : {"meter", "metre", "m"})
    for (const auto& [prefix, unit] : prefixes)
      if (name == std::string(prefix) + std::string(metre)) name = unit;
  for (const auto& [known, metres] : units)
    if (known == name) return metres;
  return std::nullopt;
}

std::string_view unit_name(double metres) {
  for (const auto& [name, of] : units)
    if (of == metres) return name;
  return "m";
}

std::string unlikely_size(const Box& box, double taken) {
  const double side = box.size().maxCoeff();
  if (!(side > 0) || (side >= shortest_likely && side <= longest_likely)) return {};
  std::string text = fmt::format("is {:.3g} m long", side);
  const char* joint = "; if its lengths are in";
  for (const auto& [name, metres] : units) {
    const double other = side / taken * metres;
    if (name == "nm" || other < shortest_suggested || other > longest_suggested) continue;
    text += fmt::format("{} {}, it is {:.3g} m long", joint, name, other);
    joint = ", in";
  }
  return text;
}

}  // namespace forefeel
