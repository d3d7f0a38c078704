#include "scheduling/session/arrivals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/common/dispatch_file.hpp"
#include "scheduling/common/records.hpp"

namespace forefeel {
namespace {

void check_near(const Vec3& at, double farthest, const std::filesystem::path& file, std::size_t line) {
  if (!(at.norm() <= farthest))
    throw InputError({.file = file.string(), .line = line}, too_far(at.norm(), farthest));
}

}  // namespace

std::string too_far(double distance, double farthest) {
  std::string text = fmt::format("is {:.6g} m from rest, expected at most {:.6g} m, twice the body's length",
                                 distance, farthest);
  if (distance > 10 * farthest) text += " (are the values in metres?)";
  return text;
}

std::vector<Arrival> read_arrivals(const std::filesystem::path& file, double farthest) {
  constexpr std::string_view columns[] = {"t", "x", "y", "z", "sx", "sy", "sz"};
  std::string header;
  std::getline(std::ifstream(file), header);
  const bool sites = header.find("sx") != std::string::npos;
  const CsvTable table = read_csv(file, std::span(columns).first(sites ? 7 : 4));
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.at(i, 0) < 0)
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       "t is negative, expected seconds from the start");
    if (table.at(i, 0) > 86400)
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("t is {} s, expected at most 86400, a day", table.at(i, 0)));
    const Vec3 at(table.at(i, 1), table.at(i, 2), table.at(i, 3));
    check_near(at, farthest, file, table.lines[i]);
    arrivals.push_back({table.at(i, 0), at});
    if (sites)
      arrivals.back().site = {.facet = 0, .at = Vec3(table.at(i, 4), table.at(i, 5), table.at(i, 6))};
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.t < b.t; });
  return arrivals;
}

Replay read_replay(const std::filesystem::path& run_folder, double farthest) {
  Replay replay{.motion = read_trace(run_folder / "frames.csv", true), .arrivals = {}, .of_arrivals = false};
  const CsvText frames = CsvText::read(run_folder / "frames.csv", "the frames of a run");
  for (std::size_t row = 0; row < frames.rows() && !replay.anywhere; ++row)
    replay.anywhere = !frames.text(row, "touch").empty();
  const auto dispatch = run_folder / "dispatch.csv";
  const std::vector<DispatchRow> rows =
      read_dispatch(dispatch);  // none in a run in which nothing was dispatched
  for (const DispatchRow& row : rows) {
    if (!row.became_known() || !std::isfinite(row.known)) continue;
    replay.of_arrivals = replay.of_arrivals || row.status == name(DispatchStatus::arrived);
    check_near(row.at, farthest, dispatch, row.line);
    Arrival arrival{.t = row.known, .at = row.at};
    if (row.site.allFinite()) arrival.site = {.facet = 0, .at = row.site};
    replay.arrivals.push_back(arrival);
  }
  std::stable_sort(replay.arrivals.begin(), replay.arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.t < b.t; });
  return replay;
}

}  // namespace forefeel
