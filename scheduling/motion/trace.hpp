#pragma once
// A motion given by samples, as --device trace:FILE and --replay play it:
// x(t) by cubic Hermite interpolation between the samples (slopes by central differences, zero at both ends), held after
// the last one.

#include <filesystem>
#include <memory>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

class Device;

struct Trace {
  std::vector<double> times;    // growing, the first 0 [s]
  std::vector<Vec3> positions;  // [m]
};

// CSV t,x,y,z in SI units; the first time becomes 0. InputError(file:line) for short rows, values that are not finite,
// times that do not grow, a file without rows.
Trace read_trace(const std::filesystem::path& file);
std::unique_ptr<Device> make_trace_device(Trace trace);

// The file in the folder where there is one, else the path as it is: relative to the working directory.
std::filesystem::path found_from(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace forefeel
