#include "geometry/mesh/length_unit.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace forefeel {
namespace {

constexpr std::array<std::pair<std::string_view, double>, 4> units{
    {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}}};
constexpr double shortest_likely = 1e-3, longest_likely = 3;        // where no other unit is suggested [m]
constexpr double shortest_suggested = 5e-3, longest_suggested = 2;  // longest side of an organ or limb [m]

}  // namespace

std::optional<double> unit_of(std::string_view name) {
  for (const auto& [known, metres] : units)
    if (known == name) return metres;
  return std::nullopt;
}

std::string unlikely_size(const Box& box, double taken) {
  const double side = box.size().maxCoeff();
  if (!(side > 0) || (side >= shortest_likely && side <= longest_likely)) return {};
  std::string text = fmt::format("is {:.3g} m long", side);
  const char* joint = "; if its lengths are in";
  for (const auto& [name, metres] : units) {
    const double other = side / taken * metres;
    if (other < shortest_suggested || other > longest_suggested) continue;
    text += fmt::format("{} {}, it is {:.3g} m long", joint, name, other);
    joint = ", in";
  }
  return text;
}

}  // namespace forefeel
