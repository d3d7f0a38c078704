// forefeel bench viscosity [SCENE] [-o DIR]: relaxation, creep under a constant force, and hysteresis loops of a viscous
// scene. The force is the tight elastic one after the loop's relaxation filter, beside the exact solution
// (viscous_curves.hpp). The tip moves straight into the body.
//   error      largest difference from the exact solution, of its largest value
//   lost       energy that a period of the loop takes, the area enclosed [J]
//   row        a step of the filter; baseline: the hereditary integral over a second of frames

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/bench/bench.hpp"
#include "apps/bench/viscous_curves.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene/laboratory.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/common/result_folder.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double frame = 1e-3;  // of the loop [s]
constexpr std::size_t intervals = 24, points = 200;

struct Curves {
  ViscousCurve relaxation, creep;
  std::vector<ViscousCurve> loops;
  double depth = 0, push = 0;  // [m], [N]
};

// The longest straight way from rest into the body, within the box of states and at most half of it, so that the body
// takes it.
ElasticLine elastic_line(Laboratory& laboratory, const Vec3& inward, const ShowShare& show) {
  const Box& box = laboratory.scene().space.box;
  double reach = 1e9;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(inward[axis]) > 1e-9)
      reach = std::min(reach, (inward[axis] > 0 ? box.high[axis] : box.low[axis]) / inward[axis]);
  std::vector<Vec3> at;
  for (std::size_t i = 0; i <= intervals; ++i)
    at.push_back(0.5 * reach * static_cast<double>(i) / intervals * inward);
  std::vector<State> states = laboratory.references(at, show);
  const auto bad = std::ranges::find_if(states, [](const State& s) { return !s.usable(); });
  states.erase(bad, states.end());
  if (states.size() < 4)
    throw InputError("bench viscosity", "the body cannot be pressed in from rest, expected solvable states");
  return {states, inward};
}

Curves make_curves(const ElasticLine& line, const Viscosity& viscosity) {
  Curves curves{.relaxation = relaxation_curve(line, viscosity, frame, points), .creep = {}, .loops = {}};
  curves.depth = line.depth();
  curves.push = 0.9 * long_term_share(viscosity) * line.force(line.depth());
  curves.creep = creep_curve(line, viscosity, curves.push, frame, points);
  double logarithm = 0;
  for (const MaxwellBranch& branch : viscosity) logarithm += std::log(branch.time);
  const double middle = std::exp(logarithm / static_cast<double>(viscosity.size()));
  for (const double periods : {20.0, 6.0, 1.0})
    curves.loops.push_back(hysteresis_loop(
        line, viscosity, frame * std::max(20.0, std::round(periods * middle / frame)), frame));
  return curves;
}

std::string lines_of(const ViscousCurve& curve, double x_scale, double y_scale) {
  std::string text;
  for (std::size_t i = 0; i < curve.x.size(); ++i)
    text +=
        fmt::format("{} {} {}\n", x_scale * curve.x[i], y_scale * curve.filter[i], y_scale * curve.exact[i]);
  return text;
}

// The filter as dots on the line of the exact solution.
std::string script_of(const Curves& curves) {
  std::string data = data_block("relaxation", lines_of(curves.relaxation, 1, 1)) +
                     data_block("creep", lines_of(curves.creep, 1, 1e3));
  std::string loops;
  for (std::size_t i = 0; i < curves.loops.size(); ++i) {
    data += data_block(fmt::format("loop{}", i), lines_of(curves.loops[i], 1e3, 1));
    const auto every = std::max<std::size_t>(1, curves.loops[i].x.size() / 40);
    loops += fmt::format(
        "{0}$loop{1} using 1:3 with lines lw 1.5 lc rgb '{2}' title '{3:.3g} s', $loop{1} every {4} using "
        "1:2 with points "
        "pt 7 ps 0.35 lc rgb '{5}' notitle",
        i > 0 ? ", " : "", i, line_colour(i), curves.loops[i].period, every, ink("rendered"));
  }
  const auto panel = [](const std::string& name, const std::string& title, const std::string& y) {
    return fmt::format(
        "set title '{1}'\nset xlabel 'time [s]'\nset ylabel '{2}'\nset logscale x\nplot [0.001:] ${0} using "
        "1:3 with lines "
        "lw 2 lc rgb '{3}' title 'exact', ${0} every 6 using 1:2 with points pt 7 ps 0.4 lc rgb '{4}' title "
        "'filter'\n",
        name, title, y, ink("reference_light"), ink("rendered"));
  };
  return data + plot_style + "set key top right samplen 1\nset yrange [0:*]\nset multiplot layout 1,3\n" +
         panel("relaxation", fmt::format("held at {:.3g} mm", 1e3 * curves.depth), "force [N]") +
         "set key bottom right\n" +
         panel("creep", fmt::format("pushed by {:.3g} N", curves.push), "depth [mm]") +
         "unset logscale x\nset key top left\nset title 'pressed in and out'\nset xlabel 'depth [mm]'\nset "
         "ylabel "
         "'force [N]'\nset yrange [*:*]\nplot " +
         loops + "\nunset multiplot\n";
}

std::string csv_of(const Curves& curves) {
  std::string text = "curve,period_s,x,filter,exact\n";
  const auto add = [&](const char* name, const ViscousCurve& curve) {
    for (std::size_t i = 0; i < curve.x.size(); ++i)
      text += fmt::format("{},{},{:.9g},{:.12g},{:.12g}\n", name,
                          curve.period > 0 ? fmt::format("{}", curve.period) : "", curve.x[i],
                          curve.filter[i], curve.exact[i]);
  };
  add("relaxation", curves.relaxation);                                   // x: time [s], values: force [N]
  add("creep", curves.creep);                                             // x: time [s], values: depth [m]
  for (const ViscousCurve& loop : curves.loops) add("hysteresis", loop);  // x: depth [m], values: force [N]
  return text;
}

// Times of one step [us]: the filter, and the integral over the frames of one second.
std::pair<double, double> step_times(const Viscosity& viscosity) {
  constexpr std::size_t steps = 20000, history = 1000;
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto since = [&](auto start) {
    return std::chrono::duration<double, std::micro>(now() - start).count();
  };
  std::vector<double> ours, theirs, weights(history);
  for (std::size_t i = 0; i < history; ++i)
    weights[i] = relaxation(viscosity, frame * static_cast<double>(i));
  std::vector<Vec3> changes(history, Vec3(1e-3, 2e-3, -1e-3));
  Vec3 sum = Vec3::Zero();
  for (int round = 0; round < 7; ++round) {  // in turns, so that other load affects both alike
    RelaxationFilter filter(viscosity);
    auto start = now();
    for (std::size_t i = 0; i < steps; ++i) sum += filter.step(changes[i % history], frame);
    ours.push_back(since(start) / steps);
    start = now();
    for (std::size_t step = 0; step < steps / 100; ++step) {
      changes[step % history].x() += 1e-9;
      for (std::size_t i = 0; i < history; ++i) sum += weights[i] * changes[i];
    }
    theirs.push_back(since(start) / (steps / 100.0));
  }
  return {sum.allFinite() ? quantile_of(ours, 0.5) : unknown, quantile_of(theirs, 0.5)};
}

Json loops_json(const std::vector<ViscousCurve>& loops) {
  Json list = Json::array();
  for (const ViscousCurve& loop : loops)
    list.push_back({{"period", number(loop.period)},
                    {"lost", number(loop.area(loop.filter))},
                    {"lost_exact", number(loop.area(loop.exact))},
                    {"error", number(loop.largest())}});
  return list;
}

Json document_of(const Laboratory& laboratory, const Viscosity& viscosity, const Curves& curves) {
  const auto [ours, theirs] = step_times(viscosity);
  std::vector<double> errors{curves.relaxation.largest(), curves.creep.largest()};
  for (const ViscousCurve& loop : curves.loops) errors.push_back(loop.largest());
  Json row{{"name", fmt::format("relaxation filter, {} branches", viscosity.size())},
           {"baseline", "integral over 1 s"},
           {"ratio", number(theirs / ours)},
           {"ours_us", number(ours)},
           {"baseline_us", number(theirs)},
           {"error", quantiles_json(errors)},
           {"n", nullptr},
           {"k", nullptr},
           {"scene", laboratory.name()},
           {"law", name(laboratory.scene().body->material.law)},
           {"elements", laboratory.scene().body->mesh.tets.size()},
           {"threads", 1},
           {"tolerance", nullptr}};
  Json document;
  document["rows"] = Json::array({std::move(row)});
  Json branches = Json::array();
  for (const MaxwellBranch& branch : viscosity)
    branches.push_back({{"share", branch.share}, {"time", branch.time}});
  document["viscosity"] = std::move(branches);
  document["depth"] = number(curves.depth);
  document["relaxation"] = {{"error", number(curves.relaxation.largest())},
                            {"long_term_share", number(long_term_share(viscosity))}};
  document["creep"] = {{"force", number(curves.push)},
                       {"from", number(curves.creep.filter.front())},
                       {"to", number(curves.creep.filter.back())},
                       {"error", number(curves.creep.largest())}};
  document["hysteresis"] = loops_json(curves.loops);
  return document;
}

}  // namespace

int bench_viscosity(const Globals& globals, const std::string& scene, const std::string& folder) {
  Laboratory laboratory(globals, scene);
  const SessionInput input = laboratory.session_input();
  Viscosity viscosity = input.touched.viscosity;
  if (viscosity.empty() && !laboratory.built_in())
    throw InputError(laboratory.name(),
                     "material has no viscosity, expected [[material.viscosity]] with share and time");
  if (viscosity.empty()) viscosity = {{0.3, 0.05}, {0.25, 0.5}};
  if (!folder.empty()) claim_folder(folder, {"viscosity.csv", "viscosity.svg"});
  Progress progress(globals, "bench viscosity");
  const ElasticLine line =
      elastic_line(laboratory, input.touched.inward,
                   [&](double share, const std::string& text) { progress.show(share, text); });
  const Curves curves = make_curves(line, viscosity);
  Json document = document_of(laboratory, viscosity, curves);
  document["files"] = Json::array();
  if (!folder.empty()) {
    const fs::path out(folder);
    write_whole(out / "viscosity.csv", csv_of(curves));
    document["files"].push_back("viscosity.csv");
    if (const auto svg = draw_svg("viscosity", 1200, 360, script_of(curves))) {
      write_whole(out / "viscosity.svg", *svg + "\n");
      document["files"].push_back("viscosity.svg");
    } else {
      warn(globals, "viscosity.svg is missing: gnuplot was not found or failed");
    }
  }
  document["provenance"] = provenance(laboratory.scene().source.hash);
  if (globals.json) print_json(document);
  say(globals, fmt::format("held at {:.3g} mm: the force falls to {:.3g} of {:.3g} N; error {:.2g}",
                           1e3 * curves.depth, long_term_share(viscosity), curves.relaxation.exact.front(),
                           curves.relaxation.largest()));
  say(globals, fmt::format("pushed by {:.3g} N: creeps from {:.3g} to {:.3g} mm; error {:.2g}", curves.push,
                           1e3 * curves.creep.filter.front(), 1e3 * curves.creep.filter.back(),
                           curves.creep.largest()));
  for (const ViscousCurve& loop : curves.loops)
    say(globals,
        fmt::format("pressed in and out in {:.3g} s: {:.3g} mJ lost, exact {:.3g} mJ; error {:.2g}",
                    loop.period, 1e3 * loop.area(loop.filter), 1e3 * loop.area(loop.exact), loop.largest()));
  return 0;
}

}  // namespace forefeel
