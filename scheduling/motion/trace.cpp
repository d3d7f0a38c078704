#include "scheduling/motion/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace_file.hpp"

namespace forefeel {
namespace {

class TraceDevice final : public Device {
 public:
  TraceDevice(std::vector<double> times, std::vector<Vec3> positions)
      : times_(std::move(times)), positions_(std::move(positions)), slopes_(times_.size(), Vec3::Zero()) {
    for (std::size_t i = 1; i + 1 < times_.size(); ++i)
      slopes_[i] = (positions_[i + 1] - positions_[i - 1]) / (times_[i + 1] - times_[i - 1]);
  }

  Vec3 position(double t, const Vec3&) noexcept override {
    if (t <= times_.front()) return positions_.front();
    if (t >= times_.back()) return positions_.back();
    const auto i =
        static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), t) - times_.begin());
    const double span = times_[i] - times_[i - 1], w = (t - times_[i - 1]) / span;
    const double w2 = w * w, w3 = w2 * w;
    return (2 * w3 - 3 * w2 + 1) * positions_[i - 1] + (3 * w2 - 2 * w3) * positions_[i] +
           span * ((w3 - 2 * w2 + w) * slopes_[i - 1] + (w3 - w2) * slopes_[i]);
  }
  double duration() const override { return times_.back(); }

 private:
  std::vector<double> times_;
  std::vector<Vec3> positions_, slopes_;
};

}  // namespace

std::unique_ptr<Device> make_trace_device(Trace trace) {
  return std::make_unique<TraceDevice>(std::move(trace.times), std::move(trace.positions));
}

std::filesystem::path found_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return file.is_relative() && std::filesystem::exists(folder / file) ? folder / file : file;
}

Trace read_trace(const std::filesystem::path& file, bool whole_lines) {
  constexpr std::string_view columns[] = {"t", "x", "y", "z"};
  const CsvTable table = read_csv(file, columns, whole_lines);
  Trace trace;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double t = table.at(i, 0) - table.at(0, 0);
    const Vec3 x(table.at(i, 1), table.at(i, 2), table.at(i, 3));
    if (!trace.times.empty() && t < trace.times.back())
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("time goes back to {} s after {} s, expected growing times",
                                   table.at(i, 0), trace.times.back() + table.at(0, 0)));
    if (!trace.times.empty() && t == trace.times.back())
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("a second row at {} s, expected growing times", table.at(i, 0)));
    trace.times.push_back(t);
    trace.positions.push_back(x);
  }
  return trace;
}

Trace trace_of(TraceRows rows, const std::filesystem::path& file) {
  for (std::size_t i = 1; i < rows.times.size(); ++i) {
    if (rows.times[i] > rows.times[i - 1]) continue;
    const bool again = rows.times[i] == rows.times[i - 1];
    throw InputError(
        {.file = file.string(), .line = rows.lines[i]},
        fmt::format("{} {:.9g} s after the first row{}, expected growing times{}",
                    again ? "a second row at" : "time goes back to", rows.times[i],
                    again ? "" : fmt::format(", from {:.9g} s", rows.times[i - 1]),
                    again ? "; forefeel trace … -o OUT.csv keeps the first row of each time" : ""));
  }
  return {.times = std::move(rows.times), .positions = std::move(rows.positions)};
}

Trace read_trace(const std::filesystem::path& file, const TraceFormat& format) {
  const MissingPositions missing = format.is_usual() ? MissingPositions::refuse : MissingPositions::leave_out;
  return trace_of(read_trace_rows(file, format, missing), file);
}

}  // namespace forefeel
