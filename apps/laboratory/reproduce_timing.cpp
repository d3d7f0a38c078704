// The paper's times (section 4) beside ours on this machine: update of the coefficients and evaluation of the
// force, with 100 and 300 states of the scene's box. Medians over HIP positions along a motion through the
// box; one thread.
//   select       the n nearest states
//   Eq. 2        assembled completely and solved by LU, as in the paper (Eigen's LU, our instruction set)
//   refit        our solution of the same system from scratch
//   update       our updater after a motion of a quarter spacing: k of n states replaced
//   evaluate     the force from the model

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "approx/model/neighbours.hpp"
#include "apps/console/json.hpp"
#include "apps/laboratory/lu_refit.hpp"
#include "apps/laboratory/paper_states.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/instruction_set.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

constexpr std::size_t error_samples = 60;

double now_us() {
  using Microseconds = std::chrono::duration<double, std::micro>;
  return Microseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Times of the paper, on two dual-core Opteron 2218 at 2.6 GHz [us].
struct PaperTimes {
  double update, evaluate_low, evaluate_high;
};
std::optional<PaperTimes> paper_times(std::size_t n) {
  if (n == 100) return PaperTimes{160e3, 60, 60};
  if (n == 300) return PaperTimes{1.6e6, 200, 250};
  return {};
}

struct TimingRow {
  std::string method;
  ModelOptions model;
  std::vector<double> select = {}, direct = {}, refit = {}, update = {}, evaluate = {}, replaced = {},
                      errors = {};  // [us], [1], [1]
};

std::vector<Sample> samples_of(const StateSpace& space, const std::vector<StateId>& ids) {
  std::vector<Sample> samples;
  for (const StateId id : ids) samples.push_back({id, space[id].at, space[id].force, space[id].stiffness});
  return samples;
}

// Positions a quarter spacing apart on a Lissajous curve through the middle 70 % of the box.
std::vector<Vec3> motion(const StateSpaceOptions& options, std::size_t count) {
  std::vector<Vec3> path;
  double u = 0;
  const Vec3 half = 0.35 * options.box.size(), middle = options.box.centre();
  const auto at = [&](double v) {
    return Vec3(middle +
                half.cwiseProduct(Vec3(std::sin(2 * v), std::sin(3 * v + 0.5), std::sin(5 * v + 1))));
  };
  while (path.size() < count) {
    path.push_back(at(u));
    const Vec3 here = at(u);
    for (int i = 0; i < 100000 && (at(u) - here).norm() < 0.25 * options.spacing; ++i) u += 1e-4;
  }
  return path;
}

void measure(TimingRow& row, const StateSpace& space, std::size_t rounds) {
  const std::vector<Vec3> path = motion(space.options(), rounds);
  NeighbourSelector selector(space, row.model);
  ModelUpdater fresh(space, row.model), kept(space, row.model);
  const bool lu_fits = row.model.kernel == Kernel::cubic || row.model.data == Data::force_and_stiffness;
  std::optional<LuRefit> lu;
  if (lu_fits) lu.emplace(row.model.neighbours, row.model.data == Data::force_and_stiffness);
  Model model, followed;
  model.reserve(row.model);
  followed.reserve(row.model);
  std::vector<Neighbour> chosen;
  std::vector<StateId> ids;
  Vec3 sum = Vec3::Zero();
  double sink = 0;
  for (const Vec3& x : path) {
    double start = now_us();
    selector.select(x, chosen);
    const double select = now_us() - start;
    ids.clear();
    for (const Neighbour& c : chosen) ids.push_back(c.id);
    row.select.push_back(select);
    const std::vector<Sample> samples = samples_of(space, ids);
    if (lu && ids.size() == row.model.neighbours) {
      start = now_us();
      sink += lu->refit(samples);
      row.direct.push_back(now_us() - start);
    }
    fresh.forget();
    start = now_us();
    fresh.update(x, model);
    row.refit.push_back(now_us() - start - select);
    UpdateReport report;
    start = now_us();
    kept.update(x, followed, &report);
    row.update.push_back(now_us() - start - select);
    row.replaced.push_back(static_cast<double>(report.replaced));
    constexpr int repeats = 64;
    start = now_us();
    for (int i = 0; i < repeats; ++i) sum += model.force(x);
    row.evaluate.push_back((now_us() - start) / repeats);
  }
  if (!sum.allFinite() || !std::isfinite(sink)) row.evaluate.assign(1, unknown);
}

void measure_errors(TimingRow& row, const StateSpace& space, const std::vector<State>& references,
                    double floor) {
  ModelUpdater updater(space, row.model);
  Model model;
  for (const State& s : references) {
    if (!s.usable()) continue;
    updater.forget();
    updater.update(s.at, model);
    row.errors.push_back((model.force(s.at) - s.force).norm() / std::max(s.force.norm(), floor));
  }
}

std::vector<TimingRow> methods(std::size_t states) {
  std::vector<TimingRow> rows;
  for (const std::size_t n : {std::size_t{100}, std::size_t{300}})
    for (const Kernel kernel : {Kernel::linear, Kernel::cubic})
      if (n <= states)
        rows.push_back({fmt::format("{}, n {}", kernel == Kernel::linear ? "r" : "r3", n),
                        {.kernel = kernel, .data = Data::force, .neighbours = n, .select = Select::nearest}});
  rows.push_back({fmt::format("Hermite r5, n {}", std::min<std::size_t>(25, states)), our_default().model});
  rows.back().model.neighbours = std::min<std::size_t>(25, states);
  return rows;
}

nlohmann::ordered_json to_json(const TimingRow& row) {
  nlohmann::ordered_json r;
  r["method"] = row.method;
  r["n"] = row.model.neighbours;
  r["kernel"] = name(row.model.kernel);
  r["data"] = name(row.model.data);
  r["select_us"] = number(median(row.select));
  r["direct_us"] = number(median(row.direct));
  r["refit_us"] = number(median(row.refit));
  r["update_us"] = number(median(row.update));
  r["replaced"] = number(median(row.replaced));
  r["evaluate_us"] = number(median(row.evaluate));
  const bool papers = row.model.data == Data::force;
  const auto paper = papers ? paper_times(row.model.neighbours) : std::nullopt;
  r["paper_update_us"] = paper ? number(paper->update) : nullptr;
  r["paper_evaluate_us"] = paper ? nlohmann::ordered_json{paper->evaluate_low, paper->evaluate_high}
                                 : nlohmann::ordered_json(nullptr);
  r["error"] = quantiles_json(row.errors);
  return r;
}

std::string in_us(double us) {
  return !std::isfinite(us) ? "–"
         : us >= 1e5        ? fmt::format("{:.3g} s", 1e-6 * us)
         : us >= 1e3        ? fmt::format("{:.3g} ms", 1e-3 * us)
                            : fmt::format("{:.3g} µs", us);
}

std::string csv(const std::vector<TimingRow>& rows) {
  std::string text =
      "method,n,select_us,direct_us,refit_us,update_us,replaced,evaluate_us,paper_update_us,paper_evaluate_"
      "us,error_p50,error_p95,error_max\n";
  for (const TimingRow& row : rows) {
    const auto paper = row.model.data == Data::force ? paper_times(row.model.neighbours) : std::nullopt;
    const auto value = [](double v) { return std::isfinite(v) ? fmt::format("{:.5g}", v) : std::string(); };
    text += fmt::format("\"{}\",{},{},{},{},{},{},{},{},{},{},{},{}\n", row.method, row.model.neighbours,
                        value(median(row.select)), value(median(row.direct)), value(median(row.refit)),
                        value(median(row.update)), value(median(row.replaced)), value(median(row.evaluate)),
                        paper ? value(paper->update) : "",
                        paper ? value(0.5 * (paper->evaluate_low + paper->evaluate_high)) : "",
                        value(quantile_of(row.errors, 0.5)), value(quantile_of(row.errors, 0.95)),
                        value(quantile_of(row.errors, 1)));
  }
  return text;
}

std::string table(const std::vector<TimingRow>& rows) {
  std::vector<std::vector<std::string>> cells{{"method", "paper: update", "evaluation", "here: select",
                                               "Eq. 2 by LU", "refit", "update", "replaced k", "evaluation",
                                               "error p50", "p95", "max"}};
  for (const TimingRow& row : rows) {
    const auto paper = row.model.data == Data::force ? paper_times(row.model.neighbours) : std::nullopt;
    const auto error = [&](double share) { return fmt::format("{:.2g}", quantile_of(row.errors, share)); };
    cells.push_back({row.method, paper ? in_us(paper->update) : "–",
                     !paper ? "–"
                     : paper->evaluate_low == paper->evaluate_high
                         ? in_us(paper->evaluate_low)
                         : fmt::format("{:g} to {:g} µs", paper->evaluate_low, paper->evaluate_high),
                     in_us(median(row.select)), in_us(median(row.direct)), in_us(median(row.refit)),
                     in_us(median(row.update)), fmt::format("{:.0f}", median(row.replaced)),
                     in_us(median(row.evaluate)), error(0.5), error(0.95), error(1)});
  }
  return html_table(cells);
}

Figure picture(const std::vector<TimingRow>& rows) {
  struct Kind {
    const char* title;
    double (*of)(const TimingRow&);
    int point;
    std::size_t colour;
  };
  const std::vector<Kind> kinds{
      {"paper: update",
       [](const TimingRow& r) {
         return r.model.data == Data::force ? paper_times(r.model.neighbours)->update : unknown;
       },
       4, 0},
      {"paper: evaluation",
       [](const TimingRow& r) {
         return r.model.data == Data::force ? paper_times(r.model.neighbours)->evaluate_high : unknown;
       },
       6, 0},
      {"Eq. 2 by LU", [](const TimingRow& r) { return median(r.direct); }, 5, 4},
      {"our refit", [](const TimingRow& r) { return median(r.refit); }, 9, 1},
      {"our update, as the HIP moves", [](const TimingRow& r) { return median(r.update); }, 13, 1},
      {"our evaluation", [](const TimingRow& r) { return median(r.evaluate); }, 7, 2}};
  std::string script, tics, plot;
  for (std::size_t i = 0; i < rows.size(); ++i)
    tics += fmt::format("{}'{}' {}", i > 0 ? ", " : "", rows[i].method, i);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    std::string lines;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (const double v = kinds[k].of(rows[i]); std::isfinite(v)) lines += fmt::format("{} {:.6g}\n", i, v);
    script += data_block(fmt::format("k{}", k), lines);
    plot += fmt::format("{}$k{} using 1:2 with points pt {} ps 1.2 lw 2 lc rgb '{}' title '{}'",
                        k > 0 ? ", " : "plot 1000 with lines lw 1 dt 2 lc rgb '#6a6a6a' title 'a frame', ", k,
                        kinds[k].point, line_colour(kinds[k].colour), kinds[k].title);
  }
  script += plot_style;
  script += fmt::format(
      "set logscale y\nset yrange [0.01:1e7]\nset format y '10^{{%T}}'\nset ylabel 'time [µs]'\nset xrange "
      "[-0.5:{}]\nset xtics ({}) noenhanced\n"
      "set key outside right center samplen 1.5\n{}\n",
      static_cast<double>(rows.size()) - 0.5, tics, plot);
  return {"timing",
          "Medians. The paper's figures are from its own machine (2.6 GHz Opteron), ours from this one; "
          "squares and circles in red are the paper's.",
          960, 400, script};
}

std::string what_we_found(const std::vector<TimingRow>& rows) {
  std::string text =
      fmt::format("On this machine, one thread, {} instructions: ", name(instruction_set_in_use()));
  for (const TimingRow& row : rows) {
    const double direct = median(row.direct);
    text += fmt::format(
        "{}: {}our refit {}, our update {} (a quarter spacing of motion replaces {:.0f} "
        "states), a force {}, error p95 {:.2g}; ",
        row.method, std::isfinite(direct) ? "Eq. 2 by LU " + in_us(direct) + ", " : "",
        in_us(median(row.refit)), in_us(median(row.update)), median(row.replaced),
        in_us(median(row.evaluate)), quantile_of(row.errors, 0.95));
  }
  text.resize(text.size() - 2);
  text += ".";
  for (const TimingRow& r : rows)
    for (const TimingRow& r3 : rows)
      if (r.model.kernel == Kernel::linear && r3.model.kernel == Kernel::cubic &&
          r3.model.data == Data::force && r.model.neighbours == r3.model.neighbours)
        text += fmt::format(
            " With {} states r takes {:.2f} times as long as r3 to refit, {:.2f} times to update and {:.2f} "
            "times for a force.",
            r.model.neighbours, median(r.refit) / median(r3.refit), median(r.update) / median(r3.update),
            median(r.evaluate) / median(r3.evaluate));
  return text;
}

}  // namespace

Findings reproduce_timing(Laboratory& laboratory, const ReproduceOptions& options,
                          const std::filesystem::path& folder, const ShowShare& show) {
  const StateSpaceOptions& space_options = laboratory.scene().space;
  const std::vector<State> states =
      laboratory.lattice_states(space_options.box, space_options.spacing,
                                [&](double share, const std::string& text) { show(0.4 * share, text); });
  StateSpace space(space_options);
  for (const State& state : states) space.insert(state);
  std::vector<Vec3> at;
  for (std::uint64_t i = 0; i < error_samples; ++i) {
    const Vec3 share(random::uniform(random::mix(31, 3 * i)), random::uniform(random::mix(31, 3 * i + 1)),
                     random::uniform(random::mix(31, 3 * i + 2)));
    at.push_back(space_options.box.low + share.cwiseProduct(space_options.box.size()));
  }
  const std::vector<State> references = laboratory.references(
      at, [&](double share, const std::string& text) { show(0.4 + 0.4 * share, text); });
  std::vector<TimingRow> rows = methods(states.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    show(0.8 + 0.2 * static_cast<double>(i) / static_cast<double>(rows.size()), rows[i].method);
    measure_errors(rows[i], space, references, laboratory.scene().session.judging.error_floor);
    measure(rows[i], space, options.rounds);
  }
  write_whole(folder / "timing.csv", csv(rows));

  Findings findings;
  findings.summary["states"] = states.size();
  findings.summary["instruction_set"] = name(instruction_set_in_use());
  findings.summary["rows"] = nlohmann::ordered_json::array();
  for (const TimingRow& row : rows) findings.summary["rows"].push_back(to_json(row));
  const std::string found = what_we_found(rows);
  findings.html = paragraph("The paper found",
                            "For 100 states an update of the coefficients takes 160 ms on average and a "
                            "force 60 µs; for 300 states 1.6 s and 200 to 250 µs. So the "
                            "force can be computed inside the haptic loop, while an update spreads over "
                            "dozens of its iterations and more.") +
                  paragraph("We found", found) + draw_into(folder, picture(rows)) + table(rows);
  findings.lines = {found};
  return findings;
}

}  // namespace forefeel
