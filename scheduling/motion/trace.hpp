#pragma once
// A motion given by samples, for --device trace:FILE and --replay. x(t) interpolates the samples by cubic
// Hermite polynomials (slopes by central differences, zero at both ends). After the last sample the position
// is held.

#include <filesystem>
#include <memory>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {

class Device;
struct TraceRows;

struct Trace {
  std::vector<double> times;    // strictly increasing, the first is 0 [s]
  std::vector<Vec3> positions;  // [m]
};

// Reads CSV t,x,y,z in SI units; times are shifted so that the first is 0. InputError(file:line) for short rows, values
// that are not finite, times that do not increase, a file without rows. whole_lines: also refuses a last line without a
// line break, as in frames.csv of a run whose disk was full.
Trace read_trace(const std::filesystem::path& file, bool whole_lines = false);
// The same for a table in another format (trace_file.hpp). In the usual format (t,x,y,z in SI units) each row needs a
// position. In other formats, rows without a position are ignored.
Trace read_trace(const std::filesystem::path& file, const TraceFormat& format);
// Makes a motion of the rows in their order. InputError naming `file` if the times do not increase.
Trace trace_of(TraceRows rows, const std::filesystem::path& file);
std::unique_ptr<Device> make_trace_device(Trace trace);

// folder/file if that exists; otherwise returns `file` unchanged, relative to the working directory.
std::filesystem::path found_from(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace forefeel
