#pragma once
// What `forefeel info` says of a label volume: voxels, their size, where the axes point, and the labels.

#include <string>

namespace forefeel {

struct Globals;

int info_labels(const Globals& globals, const std::string& file);

}  // namespace forefeel
