#include "apps/laboratory/extrapolation_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace forefeel::fig2 {
namespace {

constexpr double step = 1.0 / 60;  // of the path, in spacings (0.1 mm at 6 mm)
constexpr int steps_per_reference = 20;

// The force of the method along the path, one neighbour set after the other.
std::vector<PathPoint> walk(const PaperStates& paper, const StateSpace& space, const PathMethod& method,
                            const std::vector<double>& stations) {
  ModelUpdater updater(space, method.model);
  Model now, before;
  std::vector<PathPoint> points;
  for (const double s : stations) {
    const Vec3 x = paper.at(s);
    UpdateReport report;
    if (!method.ours) updater.forget();  // the paper's rule does not depend on the earlier set
    updater.update(x, now, &report);
    PathPoint point{.s = s, .force = now.force(x)};
    point.label = report.label;
    if (!points.empty()) point.jump = (point.force - before.force(x)).norm();
    for (const StateId id : now.states())
      ++(paper.along(space[id].at) > 0.5 * paper.far_side() ? point.far_side : point.near_side);
    points.push_back(point);
    std::swap(now, before);
  }
  return points;
}

Jump jump_at(const Curve& curve, std::size_t i, const Judge& judge) {
  const PathPoint& p = curve.points[i];
  return {p.s, p.jump, judge.in_jnd(p.jump, p.force)};
}

}  // namespace

Fig2 run_all(Laboratory& laboratory, const PaperStates& paper, const Judge& judge, const ShowShare& show) {
  std::vector<double> stations;
  const auto last = static_cast<int>(std::lround(paper.depth() / paper.spacing() / step));
  for (int i = 0; i <= last; ++i) stations.push_back(paper.depth() * i / last);
  Fig2 fig;
  std::vector<Vec3> wanted;
  std::vector<std::size_t> station_of;
  for (std::size_t i = 0; i < stations.size(); i += steps_per_reference) {
    wanted.push_back(paper.at(stations[i]));
    station_of.push_back(i);
  }
  const std::vector<State> references =
      laboratory.references(wanted, [&](double share, const std::string& text) { show(0.5 * share, text); });
  const StateSpace complete = paper.space(paper.complete());
  double walked = 0;
  const auto next_walk = [&](const PathMethod& method, const char* setup) {
    show(0.5 + 0.5 * walked++ / double(4 * paper_methods().size()),
         fmt::format("{}: {}", method.name, setup));
  };
  for (const PathMethod& method : paper_methods()) {
    next_walk(method, "all states known");
    const std::vector<PathPoint> full = walk(paper, complete, method, stations);
    for (const char* setup : {"blank", "gap", "sparse"}) {
      next_walk(method, setup);
      const StateSpace space = paper.space(paper.known(setup));
      Curve curve{setup, method, walk(paper, space, method, stations)};
      for (std::size_t i = 0; i < stations.size(); ++i) {
        curve.points[i].complete = full[i].force;
        curve.points[i].error_complete = judge.relative(curve.points[i].force, full[i].force);
      }
      for (std::size_t k = 0; k < references.size(); ++k)
        if (references[k].usable())
          curve.points[station_of[k]].error_tight =
              judge.relative(curve.points[station_of[k]].force, references[k].force);
      fig.curves.push_back(std::move(curve));
    }
  }
  fig.asked = references.size();
  for (const State& state : references)
    if (state.usable()) {
      fig.tight_s.push_back(paper.along(state.at));
      fig.tight.push_back(state.force);
    }
  return fig;
}

Largest largest(const Curve& curve, const Judge& judge, double low, double high) {
  Largest most;
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    if (const double s = curve.points[i].s; !(s > low) || s > high * (1 + 1e-9)) continue;
    const Jump jump = jump_at(curve, i, judge);
    if (std::isnan(most.jnd.s) || jump.jnd > most.jnd.jnd) most.jnd = jump;
    if (std::isnan(most.newton.s) || jump.size > most.newton.size) most.newton = jump;
  }
  return most;
}

Crossing crossing(const Curve& curve, const Judge& judge) {
  Crossing events;
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    const PathPoint &a = curve.points[i - 1], &b = curve.points[i];
    if (a.far_side == 0 && b.far_side > 0 && std::isnan(events.enters.s))
      events.enters = jump_at(curve, i, judge);
    if (a.near_side > 0 && b.near_side == 0) events.leaves = jump_at(curve, i, judge);
  }
  return events;
}

std::vector<double> errors(const Curve& curve, bool tight, double high) {
  std::vector<double> values;
  for (const PathPoint& p : curve.points)
    if (p.s <= high * (1 + 1e-9)) values.push_back(tight ? p.error_tight : p.error_complete);
  return values;
}

double at_end(const std::vector<double>& values) {
  for (auto v = values.rbegin(); v != values.rend(); ++v)
    if (std::isfinite(*v)) return *v;
  return unknown;
}

}  // namespace forefeel::fig2
