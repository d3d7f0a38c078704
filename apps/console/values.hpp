#pragma once
// Numbers and positions as typed on the command line.

#include <Eigen/Core>
#include <string>

namespace forefeel {

// A check for Option::check: an empty text if the value is such a number, else the error ("is x, expected …"). NaN and
// infinity are refused.
std::string above_zero(const std::string& text);
std::string zero_or_more(const std::string& text);
// Reads "X,Y,Z", all finite. Throws InputError that names `where`.
Eigen::Vector3d parse_vector(const std::string& text, const std::string& where);

}  // namespace forefeel
