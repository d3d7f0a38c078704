// forefeel classify RUN/: coverage over the time of a run, as a series of files for ParaView.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <span>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/offline/classify.hpp"
#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/mesh/vtu_series.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/common/dispatch_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

struct PastState {
  double time;  // [s]
  State state;
};

// The states of a run in the order in which they became known.
std::vector<PastState> read_arrivals(const fs::path& folder) {
  std::vector<PastState> arrivals;
  for (const DispatchRow& row : read_dispatch(folder / "dispatch.csv")) {
    if (!row.became_known()) continue;
    if (row.site.allFinite())
      throw InputError(folder.string(),
                       "is a run of a body that is touched anywhere, expected its session.states, "
                       "with --scene");
    const double time = std::isfinite(row.known) ? row.known : row.finished;
    State state;
    state.at = row.at;
    if (std::isfinite(time) && state.at.allFinite()) arrivals.push_back({time, state});
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const PastState& a, const PastState& b) { return a.time < b.time; });
  return arrivals;
}

// The states known at each time of a run.
struct History {
  std::vector<State> start;
  std::vector<PastState> arrivals;
  OwnFrame own;
};

History read_history(const ClassifyArguments& arguments, const fs::path& folder) {
  History history;
  history.arrivals = read_arrivals(folder);
  std::vector<State> solved;
  if (fs::exists(folder / "states.csv")) solved = read_states_csv(folder / "states.csv");
  if (!arguments.input.known.empty()) {
    StatesInFrame loaded = load_set(arguments.input.known);
    history.start = std::move(loaded.states);
    history.own = loaded.own;
  } else {
    // All states at the end, with the initial ones first.
    history.start.assign(solved.begin(),
                         solved.end() - std::ptrdiff_t(std::min(solved.size(), history.arrivals.size())));
  }
  if (fs::exists(folder / "session.states")) {
    LoadedStates loaded = load_states(folder / "session.states");
    const double other = history.own.spacing, own = loaded.header.spacing;
    if (!arguments.space.spacing && std::isfinite(other) && std::isfinite(own) &&
        std::abs(other - own) > 1e-9 * own)
      throw InputError(
          "--known",
          fmt::format("{} has a spacing of {:.4g} m and the run one of {:.4g} m, expected --spacing for both",
                      arguments.input.known, other, own));
    check_same_body(arguments.input.known, history.own.identity, loaded.header.identity);
    if (std::isfinite(own)) history.own.spacing = own;
    history.own.identity = loaded.header.identity;
    solved = std::move(loaded.states);
  }
  // Forces, stiffnesses and solve status for states that so far have only a position.
  const auto key = [](const State& s) { return std::array{s.at.x(), s.at.y(), s.at.z()}; };
  std::map<std::array<double, 3>, State> by_position;
  for (State& state : solved) by_position.try_emplace(key(state), std::move(state));
  for (PastState& arrival : history.arrivals)
    if (const auto found = by_position.find(key(arrival.state)); found != by_position.end())
      arrival.state = found->second;
  return history;
}

struct Hip {
  std::vector<double> t;
  std::vector<Vec3> at;
  std::vector<Vec3> force;  // rendered [N]
};

Hip read_hip(const fs::path& folder) {
  const CsvText table = CsvText::read(folder / "frames.csv", "a file of a run");
  Hip hip;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Vec3 at(table.number(row, "x"), table.number(row, "y"), table.number(row, "z"));
    const double t = table.number(row, "t");
    if (!std::isfinite(t) || !at.allFinite()) continue;
    hip.t.push_back(t);
    hip.at.push_back(at);
    hip.force.emplace_back(table.number(row, "fx"), table.number(row, "fy"), table.number(row, "fz"));
  }
  if (hip.t.empty())
    throw InputError({.file = (folder / "frames.csv").string()}, "holds no frames, expected columns t,x,y,z");
  return hip;
}

// Removes surplus files of an earlier, longer series.
void remove_parts(const fs::path& folder) {
  static const std::regex ours("(regions|states|hip)_[0-9]{5}\\.vtu");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (std::regex_match(entry.path().filename().string(), ours)) fs::remove(entry.path());
}

struct Moment {
  double t = 0;            // [s]
  std::size_t states = 0;  // number known by then
  Vec3 hip = Vec3::Zero();
  Label label = Label::blank;  // there
  ByLabel<double> volume{};
};

// The result of `forefeel classify RUN/`.
struct SeriesResult {
  fs::path series;  // .pvd
  std::vector<Moment> moments;
  std::size_t states = 0;  // at the end
  double spacing = unknown;
  Box box;
  RegionSummary regions;  // at the end
  Holes holes;
  double seconds = 0;
};

nlohmann::ordered_json to_json(const SeriesResult& result) {
  nlohmann::ordered_json moments = nlohmann::ordered_json::array();
  for (const Moment& m : result.moments)
    moments.push_back({{"t", m.t},
                       {"states", m.states},
                       {"hip", vector3(m.hip)},
                       {"label", std::string(name(m.label))},
                       {"volume", by_label(m.volume)}});
  nlohmann::ordered_json out{{"series", result.series.string()},
                             {"snapshots", moments},
                             {"states", result.states},
                             {"spacing", result.spacing},
                             {"box", {vector3(result.box.low), vector3(result.box.high)}}};
  add_to(out, region_keys(), {result.regions, result.holes});
  out["seconds"] = result.seconds;
  out["peak_bytes"] = peak_bytes();
  return out;
}

// The files of a series, three for each time: regions, known states, the HIP.
class SeriesFiles {
 public:
  explicit SeriesFiles(const fs::path& series)
      : series_(series), parts_(series.parent_path() / (series.stem().string() + "_series")) {
    check_writable(series_);
    fs::create_directories(parts_);
    remove_parts(parts_);
  }
  void add(std::size_t moment, double t, const RegionSummary& regions, const std::vector<State>& known,
           const State& hip) {
    write_regions_vtu(part("regions", moment, t, 0), regions.leaves, regions.components);
    write_states_vtu(part("states", moment, t, 1), known);
    write_states_vtu(part("hip", moment, t, 2), std::span(&hip, 1));
  }
  void finish() const { write_pvd(series_, entries_); }

 private:
  fs::path part(const char* what, std::size_t moment, double t, int number) {
    const std::string name = fmt::format("{}_{:05}.vtu", what, moment);
    entries_.push_back({t, number, (parts_.filename() / name).string()});
    return parts_ / name;
  }

  fs::path series_, parts_;
  std::vector<SeriesFile> entries_;
};

SeriesResult make_series(const Globals& globals, const ClassifyArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const fs::path folder = arguments.input.states;
  const History past = read_history(arguments, folder);
  const Hip hip = read_hip(folder);
  std::vector<State> all = past.start;
  for (const PastState& a : past.arrivals) all.push_back(a.state);
  const Classified set = prepare_states(arguments, folder.string(), std::move(all), past.own, globals);
  StateSpace space(
      {.spacing = set.spacing, .box = set.box, .coverage = arguments.space.coverage, .lattice = set.lattice});
  std::vector<State> so_far;
  const auto add = [&](const State& state) {
    if (state.usable() && space.insert(state).is_new) so_far.push_back(state);
  };
  for (const State& state : past.start) add(state);

  SeriesResult result;
  result.series = arguments.output.empty() ? folder / "coverage.pvd" : fs::path(arguments.output);
  SeriesFiles files(result.series);
  Progress progress(globals, "classify");
  std::size_t next = 0, labelled = ~std::size_t{0};
  const std::size_t count = std::min(arguments.places.snapshots.value_or(40), hip.t.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t frame = count == 1 ? hip.t.size() - 1 : i * (hip.t.size() - 1) / (count - 1);
    const double t = hip.t[frame];
    for (; next < past.arrivals.size() && past.arrivals[next].time <= t; ++next)
      add(past.arrivals[next].state);
    if (std::exchange(labelled, space.size()) != space.size()) result.regions = space.regions().summary();
    State probe;
    probe.at = hip.at[frame];
    probe.force = hip.force[frame];
    files.add(i, t, result.regions, so_far, probe);
    result.moments.push_back({t, space.size(), probe.at, space.label(probe.at), result.regions.volume});
    progress.show(double(i + 1) / double(count), fmt::format("t = {:.3g} s, {} states", t, space.size()));
  }
  files.finish();
  result.states = space.size();
  result.spacing = set.spacing;
  result.box = set.box;
  result.seconds = seconds_since(start);
  if (globals.json) result.holes = holes_of(space.regions());
  return result;
}

}  // namespace

int classify_run(const Globals& globals, const ClassifyArguments& arguments) {
  const SeriesResult result = make_series(globals, arguments);
  if (globals.json)
    print_json(to_json(result));
  else
    say(globals, fmt::format("{}: {} moments, {} states at the end, {:.3g} s", result.series.string(),
                             result.moments.size(), result.states, result.seconds));
  return 0;
}

}  // namespace forefeel
