// classify RUN/ and classify --diff: coverage over time, and from one set to another.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "apps/classify/classify.hpp"
#include "apps/classify/run_table.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/coverage/region_sampling.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

struct Arrival {
  double time;  // [s]
  State state;
};

// The states of a run in the order in which they became known.
std::vector<Arrival> read_arrivals(const fs::path& folder) {
  const RunTable table = RunTable::read(folder / "dispatch.csv");
  for (const char* column : {"x", "y", "z", "finished", "status"})
    if (!table.has(column))
      throw InputError({.file = (folder / "dispatch.csv").string()},
                       fmt::format("has no column {}, expected the file of a run", column));
  std::vector<Arrival> arrivals;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string_view status = table.text(row, "status");
    if (status != "solved" && status != "arrived") continue;
    const double known = table.number(row, "known"), finished = table.number(row, "finished");
    const double time = std::isfinite(known) ? known : finished;
    State state;
    state.at = {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")};
    if (std::isfinite(time) && state.at.allFinite()) arrivals.push_back({time, state});
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.time < b.time; });
  return arrivals;
}

bool before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// Forces, stiffnesses and how they were solved, for states of which only the position is known so far.
class Solved {
 public:
  explicit Solved(std::vector<State> states) : states_(std::move(states)) {
    std::stable_sort(states_.begin(), states_.end(),
                     [](const State& a, const State& b) { return before(a.at, b.at); });
  }
  void complete(State& state) const {
    const auto found = std::lower_bound(states_.begin(), states_.end(), state.at,
                                        [](const State& s, const Vec3& at) { return before(s.at, at); });
    if (found != states_.end() && found->at == state.at) state = *found;
  }

 private:
  std::vector<State> states_;  // by position
};

// What was known when, of a run.
struct History {
  std::vector<State> start;
  std::vector<Arrival> arrivals;
  OwnFrame own;
};

History read_history(const ClassifyArguments& arguments, const fs::path& folder) {
  History history;
  history.arrivals = read_arrivals(folder);
  std::vector<State> solved;
  if (fs::exists(folder / "states.csv")) solved = read_states_csv(folder / "states.csv");
  if (!arguments.known.empty()) {
    StatesInFrame loaded = load_set(arguments.known);
    history.start = std::move(loaded.states);
    history.own = loaded.own;
  } else {
    // All states at the end, those of the start first.
    history.start.assign(solved.begin(),
                         solved.end() - std::ptrdiff_t(std::min(solved.size(), history.arrivals.size())));
  }
  if (fs::exists(folder / "session.states")) {
    LoadedStates loaded = load_states(folder / "session.states");
    const double other = history.own.spacing, own = loaded.header.spacing;
    if (!arguments.spacing && std::isfinite(other) && std::isfinite(own) &&
        std::abs(other - own) > 1e-9 * own)
      throw InputError(
          "--known",
          fmt::format("{} has a spacing of {:.4g} m and the run one of {:.4g} m, expected --spacing for both",
                      arguments.known, other, own));
    check_same_body(arguments.known, history.own.identity, loaded.header.identity);
    if (std::isfinite(own)) history.own.spacing = own;
    history.own.identity = loaded.header.identity;
    solved = std::move(loaded.states);
  }
  const Solved table(std::move(solved));
  for (Arrival& arrival : history.arrivals) table.complete(arrival.state);
  return history;
}

struct Hip {
  std::vector<double> t;
  std::vector<Vec3> at;
  std::vector<Vec3> force;  // rendered [N]
};

Hip read_hip(const fs::path& folder) {
  const RunTable table = RunTable::read(folder / "frames.csv");
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

// Moments that an earlier, longer series left.
void remove_parts(const fs::path& folder) {
  static const std::regex ours("(regions|states|hip)_[0-9]{5}\\.vtu");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (std::regex_match(entry.path().filename().string(), ours)) fs::remove(entry.path());
}

}  // namespace

int classify_run(const Globals& globals, const ClassifyArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const fs::path folder = arguments.states;
  const History past = read_history(arguments, folder);
  const std::vector<Arrival>& arrivals = past.arrivals;
  const Hip hip = read_hip(folder);
  std::vector<State> all = past.start;
  for (const Arrival& a : arrivals) all.push_back(a.state);
  Classified set = prepare_states(arguments, folder.string(), std::move(all), past.own, globals);
  StateSpace space(
      {.spacing = set.spacing, .box = set.box, .coverage = arguments.coverage, .lattice = set.lattice});
  std::vector<State> so_far;
  const auto add = [&](const State& state) {
    if (state.usable() && space.insert(state).is_new) so_far.push_back(state);
  };
  for (const State& state : past.start) add(state);

  const fs::path series = arguments.output.empty() ? folder / "coverage.pvd" : fs::path(arguments.output);
  check_writable(series);
  const fs::path parts = series.parent_path() / (series.stem().string() + "_series");
  fs::create_directories(parts);
  remove_parts(parts);
  std::vector<SeriesEntry> entries;
  nlohmann::ordered_json history = nlohmann::ordered_json::array();
  Progress progress(globals, "classify");
  std::size_t next = 0;
  const std::size_t count = std::min(arguments.snapshots.value_or(40), hip.t.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t frame = count == 1 ? hip.t.size() - 1 : i * (hip.t.size() - 1) / (count - 1);
    const double t = hip.t[frame];
    for (; next < arrivals.size() && arrivals[next].time <= t; ++next) add(arrivals[next].state);
    const RegionSummary regions = space.regions().summary();
    State probe;
    probe.at = hip.at[frame];
    probe.force = hip.force[frame];
    const auto write = [&](const char* what, int part, auto&& writer) {
      const std::string name = fmt::format("{}_{:05}.vtu", what, i);
      writer(parts / name);
      entries.push_back({t, part, (parts.filename() / name).string()});
    };
    write("regions", 0,
          [&](const fs::path& file) { write_regions_vtu(file, regions.leaves, regions.components); });
    write("states", 1, [&](const fs::path& file) { write_states_vtu(file, so_far); });
    write("hip", 2, [&](const fs::path& file) { write_states_vtu(file, std::span(&probe, 1)); });
    history.push_back({{"t", t},
                       {"states", space.size()},
                       {"hip", vector3(hip.at[frame])},
                       {"label", std::string(name(space.label(hip.at[frame])))},
                       {"volume", by_label(regions.volume)}});
    progress.show(double(i + 1) / double(count), fmt::format("t = {:.3g} s, {} states", t, space.size()));
  }
  write_pvd(series, entries);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (globals.json) {
    nlohmann::ordered_json out{{"series", series.string()},
                               {"snapshots", history},
                               {"states", space.size()},
                               {"spacing", set.spacing},
                               {"box", {vector3(set.box.low), vector3(set.box.high)}}};
    const double fill = space.regions().fill_distance();
    regions_json(out, space.regions().summary(), fill, fill + 1e-3 * set.spacing,
                 space.regions().largest_hole());
    out["seconds"] = seconds;
    out["peak_bytes"] = peak_bytes();
    print_json(out);
  } else {
    say(globals, fmt::format("{}: {} moments, {} states at the end, {:.3g} s", series.string(), count,
                             space.size(), seconds));
  }
  return 0;
}

int classify_diff(const Globals& globals, const ClassifyArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  std::array<StatesInFrame, 2> loaded{load_set(arguments.diff[0]), load_set(arguments.diff[1])};
  // One spacing and one box for both, or volumes would not compare.
  std::vector<State> both = loaded[0].states;
  both.insert(both.end(), loaded[1].states.begin(), loaded[1].states.end());
  ClassifyArguments common = arguments;
  OwnFrame own = loaded[0].own;
  const double other = loaded[1].own.spacing;
  if (!arguments.spacing && arguments.scene.empty() && std::isfinite(own.spacing) && std::isfinite(other) &&
      std::abs(other - own.spacing) > 1e-9 * own.spacing)
    throw InputError(
        "--diff",
        fmt::format("{} has a spacing of {:.4g} m and {} one of {:.4g} m, expected --spacing for both",
                    arguments.diff[0], own.spacing, arguments.diff[1], other));
  check_same_body(arguments.diff[1], loaded[1].own.identity, own.identity);
  if (own.box && loaded[1].own.box)
    own.box =
        Box{own.box->low.cwiseMin(loaded[1].own.box->low), own.box->high.cwiseMax(loaded[1].own.box->high)};
  const Classified frame = prepare_states(arguments, arguments.diff[0], std::move(both), own, globals);
  common.spacing = frame.spacing;
  std::array<Classified, 2> set;
  for (std::size_t i = 0; i < 2; ++i) {
    common.box.clear();
    common.scene.clear();
    set[i] = prepare_states(common, arguments.diff[i], std::move(loaded[i].states),
                            {frame.spacing, frame.box}, globals);
    label_regions(set[i], common, globals, i == 1);
  }
  std::vector<RegionChange> changed;
  std::array<std::array<double, 4>, 4> volume{};
  const auto label_of = [&](std::size_t i, const Vec3& q) {
    return set[i].space ? set[i].space->regions().label_at(q) : set[i].octree->label(q);
  };
  const double side = frame.spacing / 4;
  for (const RegionLeaf& leaf : set[1].regions.leaves) {
    // A leaf of B may hold several of A: walk A's voxels in it.
    const Vec3 size = leaf.box.size();
    std::array<int, 3> n{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      n[axis] = std::max(1, static_cast<int>(std::lround(size[static_cast<Eigen::Index>(axis)] / side)));
    const Vec3 step = size.cwiseQuotient(Vec3(n[0], n[1], n[2]));
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          const Vec3 low = leaf.box.low + step.cwiseProduct(Vec3(i, j, k));
          const Label before = label_of(0, low + 0.5 * step);
          volume[static_cast<std::size_t>(before)][static_cast<std::size_t>(leaf.label)] += step.prod();
          if (before != leaf.label) changed.push_back({{low, low + step}, before, leaf.label});
        }
  }
  double moved = 0, better = 0;
  nlohmann::ordered_json table;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b) {
      if (a != b) moved += volume[a][b];
      if (b < a) better += volume[a][b];
      table[std::string(name(static_cast<Label>(a)))][std::string(name(static_cast<Label>(b)))] =
          volume[a][b];
    }
  if (arguments.output.ends_with(".vtu")) write_changes_vtu(arguments.output, changed);
  if (arguments.output.ends_with(".csv")) {
    OutputFile out(arguments.output);
    out.write("x,y,z,dx,dy,dz,before,after\n");
    for (const RegionChange& leaf : changed) {
      const Vec3 c = leaf.box.centre(), d = leaf.box.size();
      out.write(fmt::format("{},{},{},{},{},{},{},{}\n", c.x(), c.y(), c.z(), d.x(), d.y(), d.z(),
                            name(leaf.before), name(leaf.after)));
    }
    out.commit();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (globals.json) {
    nlohmann::ordered_json out{
        {"diff", {{"from_to", table}, {"changed", moved}, {"better", better}, {"worse", moved - better}}},
        {"states", {set[0].states.size(), set[1].states.size()}},
        {"spacing", frame.spacing}};
    regions_json(out, set[1].regions, set[1].fill_distance, set[1].fill_bound, set[1].hole);
    out["seconds"] = seconds;
    out["peak_bytes"] = peak_bytes();
    print_json(out);
    return 0;
  }
  say(globals, fmt::format("h = {:.4g} mm", 1e3 * frame.spacing));
  say(globals, "volume [cm3]  safe       sparse     gap        blank      (in B)");
  for (std::size_t a = 0; a < 4; ++a)
    say(globals, fmt::format("{:<12}{:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g}", name(static_cast<Label>(a)),
                             1e6 * volume[a][0], 1e6 * volume[a][1], 1e6 * volume[a][2], 1e6 * volume[a][3]));
  say(globals, fmt::format("changed {:.4g} cm3, {:.4g} of it for the better", 1e6 * moved, 1e6 * better));
  return 0;
}

}  // namespace forefeel
