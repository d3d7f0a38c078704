// Speed against error as a picture and as CSV.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/bench/bench_approx_parts.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel::bench {

double now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

namespace {

struct Point {
  double time, error;
  std::string name;
};

// The data blocks `name` (all points, with labels) and `name`_front, and the panel that draws them.
std::string panel(const std::string& name, const std::string& title, std::vector<Point> points) {
  std::erase_if(points, [](const Point& p) { return !(p.time > 0) || !(p.error > 0); });
  std::ranges::sort(points, {}, &Point::time);
  std::string all, front;
  double best = INFINITY;
  for (const Point& p : points) {
    all += fmt::format("{} {} \"{}\"\n", p.time, p.error, p.name);
    if (p.error >= best) continue;
    if (best < INFINITY) front += fmt::format("{} {}\n", p.time, best);
    best = p.error;
    front += fmt::format("{} {}\n", p.time, p.error);
  }
  return data_block(name, all) + data_block(name + "_front", front) +
         fmt::format(
             "set xlabel '{}'\nplot ${}_front with lines lw 2 lc rgb '{}' notitle, ${} using 1:2 with "
             "points pt 7 ps 0.6 lc rgb '{}' notitle, ${} using 1:2:3 with labels left offset 0.6,0.4 "
             "font ',8' notitle\n",
             title, name, ink("reference_light"), name, ink("rendered"), name);
}

std::string field(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : std::string();
}

}  // namespace

std::string pareto_plot(const std::vector<Measured>& all) {
  std::vector<Point> evaluation, update;
  for (const Measured& m : all) {
    const std::string name = fmt::format("{} {}", m.method, m.n);
    evaluation.push_back({m.evaluate, m.inside.p95, name});
    update.push_back({std::isfinite(m.update[1]) ? m.update[1] : m.refit, m.inside.p95, name});
  }
  return "set logscale xy\nset format y '10^{%L}'\nset ylabel 'relative error, p95'\nset grid\n"
         "set multiplot layout 1,2\n" +
         panel("evaluation", "evaluation [µs]", std::move(evaluation)) + "unset ylabel\n" +
         panel("update", "five states replaced (refit where nothing is) [µs]", std::move(update)) +
         "unset multiplot\n";
}

std::string table_csv(const Case& bench, const std::vector<Measured>& all) {
  std::string text = "method,n,refit_us,update_1_us,update_5_us,update_20_us,evaluate_us,p50,p95,max";
  for (const auto& plane : bench.outside)
    for (const char* share : {"p50", "max"})
      text += fmt::format(",outside_{:.0f}mm_{}", 1e3 * plane.distance, share);
  text += ",states_for_1_percent,states_for_7_percent\n";
  for (const Measured& m : all) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{}", m.method, m.n, field(m.refit), field(m.update[0]),
                        field(m.update[1]), field(m.update[2]), field(m.evaluate), field(m.inside.p50),
                        field(m.inside.p95), field(m.inside.max));
    for (const Errors& e : m.outside) text += fmt::format(",{},{}", field(e.p50), field(e.max));
    for (const auto& states : {m.states_for_1, m.states_for_7})
      text += states ? fmt::format(",{}", *states) : std::string(",");
    text += '\n';
  }
  return text;
}

}  // namespace forefeel::bench
