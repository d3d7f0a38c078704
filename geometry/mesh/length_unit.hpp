#pragma once
// Units of length. Most mesh files name none; a body of an unlikely size has probably been read in the wrong one.

#include <optional>
#include <string>
#include <string_view>

#include "geometry/common/types.hpp"

namespace forefeel {

inline constexpr const char* unit_names = "m, cm, mm or um";
// The unit [m] in any spelling: "um", "µm", "microns", "Micrometers"; nothing for other words.
std::optional<double> unit_of(std::string_view word);
std::string_view unit_name(double metres);  // of a known unit: "mm"

// Empty for a box of a likely size: the longest side from 5 mm to 5 m. Otherwise "is 213 m long; if its lengths are in
// mm, it is 0.213 m long". taken: the unit in which the file's lengths were taken [m].
std::string unlikely_size(const Box& box, double taken = 1);

}  // namespace forefeel
