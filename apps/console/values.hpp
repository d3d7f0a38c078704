#pragma once
// Numbers and positions as typed on the command line.

#include <Eigen/Core>
#include <string>

namespace forefeel {

// Checks for Option::check: empty where the text is such a number, else the rest of a message ("is x,
// expected …"). NaN and infinity are refused.
std::string above_zero(const std::string& text);
std::string zero_or_more(const std::string& text);
// "X,Y,Z", finite. InputError names `where`.
Eigen::Vector3d parse_vector(const std::string& text, const std::string& where);

}  // namespace forefeel
