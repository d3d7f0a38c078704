// forefeel bench approx [SCENE]: one table, speed against error, of every method on a real state space.
//   speed  fit, update and evaluation beside Eigen's LU of the whole saddle system and a scalar sum, of the same
//          instruction set (FOREFEEL_ISA asks for a lower one) and in the same run; series of each one after the
//          other, so that all find their own data in the caches; medians, one thread
//   error  against tight solves at random positions: inside the lattice, beyond a flat front of known states, and
//          with ever fewer states

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "approx/baselines/baseline.hpp"
#include "approx/loops/instruction_set.hpp"
#include "approx/predecessors/methods.hpp"
#include "apps/bench/bench_approx.hpp"

#include "apps/bench/bench.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene_input/scene.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {

namespace {

using namespace bench;
using Json = nlohmann::ordered_json;
constexpr std::size_t replacements[3] = {1, 5, 20};
constexpr int blocks = 8, per_block = 12;

struct Kind {
  std::string name;
  Kernel kernel;
  Data data;
  std::vector<std::size_t> neighbours;
};

const std::vector<Kind> kinds = {
    {"r", Kernel::linear, Data::force, {100, 300}},
    {"r3", Kernel::cubic, Data::force, {100, 300}},
    {"r5", Kernel::quintic, Data::force, {100, 300}},
    {"hermite-r3", Kernel::cubic, Data::force_and_stiffness, {25, 75}},
    {"hermite-r5", Kernel::quintic, Data::force_and_stiffness, {8, 25, 75}},
};

Errors errors_of(const std::vector<double>& values) {
  return {median(values), quantile_of(values, 0.95, QuantileRule::inverted_cdf), quantile_of(values, 1)};
}

StateSpace space_of(const std::vector<State>& states, StateSpaceOptions options) {
  StateSpace space(options);
  for (const State& s : states) space.insert(s);
  return space;
}

// force(x) against the references.
template <class Force>
Errors judge(const std::vector<State>& references, const Force& force) {
  std::vector<double> errors;
  for (const State& s : references)
    errors.push_back((force(s.at) - s.force).norm() / std::max(s.force.norm(), 0.05));
  return errors_of(errors);
}

Errors judge(const std::vector<State>& references, const StateSpace& space, const ModelOptions& options) {
  ModelUpdater updater(space, options);
  Model model;
  return judge(references, [&](const Vec3& x) {
    updater.forget();
    updater.update(x, model);
    return model.force(x);
  });
}

// One replacement: k of n states of the pool for others.
struct Change {
  std::vector<StateId> removed;
  std::vector<Sample> added, all;
};

class Bench {
 public:
  Bench(const Globals& globals, Case taken, Progress& progress)
      : globals_(globals),
        progress_(progress),
        case_(std::move(taken)),
        space_(space_of(case_.states, case_.options)) {
    std::vector<State> half;
    for (const State& s : case_.states)
      if (s.at[0] <= case_.front + 1e-9) half.push_back(s);
    half_ = std::move(half);
    half_space_.emplace(space_of(half_, case_.options));
    for (const int step : {1, 2, 3, 4, 6}) thin(step);
  }

  void run() {
    notes = case_.notes;
    std::map<std::size_t, std::vector<std::string>> too_few;
    std::size_t done = 0, all = 0;
    for (const Kind& kind : kinds) all += kind.neighbours.size();
    for (const Kind& kind : kinds)
      for (const std::size_t n : kind.neighbours) {
        progress_.show(0.5 + 0.4 * double(done++) / double(all), fmt::format("{} with {}", kind.name, n));
        if (n + replacements[2] <= space_.size())
          measure(kind, n);
        else
          too_few[n].push_back(kind.name);
      }
    for (const auto& [n, names] : too_few)
      notes.push_back(
          fmt::format("{} with n = {}: needs {} states ({} to replace), the lattice has {}, left out",
                      fmt::join(names, ", "), n, n + replacements[2], replacements[2], space_.size()));
    for (const Method method : all_methods())
      if (method != Method::rbf) {
        progress_.show(0.9, std::string(name(method)));
        try {
          measure_older(method);
        } catch (const InputError& error) {  // the states do not suit it
          notes.push_back(fmt::format("{}: {}, left out", name(method), error.what()));
        }
      }
  }

  Json rows = Json::array();
  std::vector<Measured> table;
  std::vector<std::string> notes;  // what was left out, and why
  const Case& the_case() const { return case_; }

 private:
  // Every step-th plane of the lattice.
  void thin(int step) {
    const double h = step * case_.options.spacing;
    std::vector<State> kept;
    for (const State& s : case_.states) {
      bool on = true;
      for (int d = 0; d < 3; ++d) on = on && std::abs(s.at[d] / h - std::round(s.at[d] / h)) < 1e-6;
      if (on) kept.push_back(s);
    }
    StateSpaceOptions options = case_.options;
    options.spacing = h;
    sparser_.push_back({std::move(kept), space_of({}, options)});
    for (const State& s : sparser_.back().states) sparser_.back().space.insert(s);
  }

  void measure(const Kind& kind, std::size_t n) {
    ModelOptions options{.kernel = kind.kernel, .data = kind.data, .neighbours = n};
    Measured m;
    m.method = kind.name;
    m.n = n;
    m.inside = judge(case_.inside, space_, options);
    for (const auto& plane : case_.outside)
      m.outside.push_back(judge(plane.references, *half_space_, options));
    count_states(m, [&](const Sparser& s) {
      ModelOptions fewer = options;
      fewer.neighbours = std::min(n, s.space.size());
      return judge(case_.inside, s.space, fewer).p95;
    });
    std::vector<StateId> ids;
    space_.nearest(case_.options.box.centre(), 3 * n, ids);
    pool_.clear();
    for (const StateId id : ids) pool_.push_back({id, space_[id].at, space_[id].force, space_[id].stiffness});
    time_fits(kind, options, m);
    time_evaluation(kind, options, m);
    table.push_back(std::move(m));
  }

  struct Sparser {
    std::vector<State> states;
    StateSpace space;
  };

  template <class Judge>
  void count_states(Measured& m, const Judge& p95_with) {
    for (const Sparser& s : sparser_) {  // ever fewer
      const double p95 = p95_with(s);
      if (p95 <= 0.01) m.states_for_1 = s.states.size();
      if (p95 <= 0.07) m.states_for_7 = s.states.size();
    }
  }

  void measure_older(Method method) {
    const auto field_of = [&](const std::vector<State>& states, double spacing) {
      MethodOptions options{.model = {.kernel = Kernel::cubic, .length = spacing}, .spacing = spacing};
      return Approximation(method, states, options);
    };
    const auto judged = [&](const std::vector<State>& references, const std::vector<State>& states,
                            double spacing) {
      try {
        const Approximation field = field_of(states, spacing);
        return judge(references, [&](const Vec3& x) { return field.force(x); });
      } catch (const InputError&) {  // these states do not suit the method
        return Errors{};
      }
    };
    const double h = case_.options.spacing;
    Measured m;
    m.method = name(method);
    m.n = space_.size();
    const double start = now_us();
    const Approximation field = field_of(case_.states, h);
    m.refit = now_us() - start;
    m.inside = judge(case_.inside, [&](const Vec3& x) { return field.force(x); });
    for (const auto& plane : case_.outside) m.outside.push_back(judged(plane.references, half_, h));
    count_states(
        m, [&](const Sparser& s) { return judged(case_.inside, s.states, s.space.options().spacing).p95; });
    std::vector<Vec3> at;
    for (const State& s : case_.inside) at.push_back(s.at);
    std::vector<double> times;
    for (int block = 0; block < 4 * blocks; ++block)
      times.push_back(evaluation([&](const Vec3& x) { return field.force(x); }, at, 20));
    m.evaluate = median(times);
    table.push_back(std::move(m));
  }

  std::vector<Change> changes(std::size_t n, std::size_t k) const {
    std::vector<std::size_t> in, out;
    for (std::size_t i = 0; i < pool_.size(); ++i) (i < n ? in : out).push_back(i);
    std::mt19937_64 random(globals_.seed);
    std::vector<Change> made(blocks * per_block);
    for (Change& change : made) {
      std::shuffle(in.begin(), in.end(), random);
      std::shuffle(out.begin(), out.end(), random);
      for (std::size_t i = 0; i < k; ++i) {
        change.removed.push_back(pool_[in[i]].id);
        change.added.push_back(pool_[out[i]]);
        std::swap(in[i], out[i]);
      }
      std::ranges::sort(change.removed);
      for (const std::size_t i : in) change.all.push_back(pool_[i]);
    }
    return made;
  }

  // Microseconds of step(i) for every i of a block.
  template <class Step>
  static void time_block(int block, std::vector<double>& times, const Step& step) {
    for (int i = block * per_block; i < (block + 1) * per_block; ++i) {
      const double start = now_us();
      step(static_cast<std::size_t>(i));
      times.push_back(now_us() - start);
    }
  }

  void time_fits(const Kind& kind, const ModelOptions& options, Measured& m) {
    const std::size_t n = options.neighbours;
    const bool hermite = options.data == Data::force_and_stiffness;
    std::optional<LuRefit> lu;
    if (kind.name == "r3" || kind.name == "hermite-r5") lu.emplace(n, hermite);
    ModelDraft draft;
    draft.reserve(options);
    double sink = 0;
    RbfFit own(options, n);
    std::vector<double> refits, theirs;
    for (std::size_t t = 0; t < 3; ++t) {
      const std::size_t k = replacements[t];
      if (2 * k > n) continue;
      const std::vector<Change> made = changes(n, k);
      std::vector<double> updates, own_refits, lu_refits;
      RbfFit fit(options, n);
      fit.refit({pool_.data(), n});
      std::size_t by_refit = 0;  // where the updater finds that cheaper
      for (int block = 0; block < blocks; ++block) {
        time_block(block, updates, [&](std::size_t i) {
          by_refit += fit.replace(made[i].removed, made[i].added) ? 1 : 0;
          fit.write(draft, pool_[0].at);
        });
        time_block(block, own_refits, [&](std::size_t i) {
          own.refit(made[i].all);
          own.write(draft, pool_[0].at);
        });
        if (lu) time_block(block, lu_refits, [&](std::size_t i) { sink += lu->refit(made[i].all); });
      }
      m.update[t] = median(updates);
      const double share = double(by_refit) / double(made.size());
      if (lu) row("update", m, "Eigen PartialPivLU refit", updates, lu_refits, k, share);
      row("update", m, "own refit", updates, own_refits, k, share);
      refits.insert(refits.end(), own_refits.begin(), own_refits.end());
      theirs.insert(theirs.end(), lu_refits.begin(), lu_refits.end());
    }
    m.refit = median(refits);
    if (lu) row("refit", m, "Eigen PartialPivLU refit", refits, theirs, std::nullopt);
    if (!std::isfinite(sink)) warn(globals_, "the LU baseline met a singular system");
  }

  // Microseconds of one force(x), mean of `repeats`.
  template <class Force>
  double evaluation(const Force& force, const std::vector<Vec3>& at, int repeats) const {
    Vec3 sum = Vec3::Zero();
    const Vec3 *next = at.data(), *end = next + at.size();  // a modulo would be timed with it
    const double start = now_us();
    for (int i = 0; i < repeats; ++i) {
      sum += force(*next);
      if (++next == end) next = at.data();
    }
    const double time = (now_us() - start) / repeats;
    if (!sum.allFinite()) warn(globals_, "an evaluation was not finite");
    return time;
  }

  void time_evaluation(const Kind& kind, const ModelOptions& options, Measured& m) {
    const std::size_t n = options.neighbours;
    RbfFit fit(options, n);
    fit.refit({pool_.data(), n});
    ModelDraft draft;
    fit.write(draft, pool_[0].at);
    Model model;
    model.assign(draft, 1);
    // As in the loop: HIP positions among the states of the model.
    const auto& reference = case_.inside;
    const Vec3 centre = model.data().centre;
    const double shrink = 0.5 / (model.data().inverse_scale * case_.options.box.size().norm());
    std::vector<Vec3> at;
    for (const State& s : reference) at.push_back(centre + shrink * (s.at - case_.options.box.centre()));
    constexpr int repeats = 400;
    std::vector<double> ours;
    const auto own = [&](const Vec3& x) { return model.force(x); };
    if (kind.name == "hermite-r5" && model.data().power == 5) return time_hermite(model, at, m);
    if (kind.name != "r3") {
      for (int block = 0; block < 4 * blocks; ++block) ours.push_back(evaluation(own, at, repeats));
      m.evaluate = median(ours);
      return;
    }
    const ModelData& data = model.data();
    std::vector<double> positions(3 * n), coefficients(3 * n + 12);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < n; ++i) {
        positions[3 * i + c] = data.data[c * data.stride + i];
        coefficients[3 * i + c] = data.data[(3 + c) * data.stride + i];
      }
      for (std::size_t t = 0; t < 4; ++t) coefficients[3 * n + 4 * c + t] = data.polynomial[t][c];
    }
    const auto scalar = [&](const Vec3& x) {
      const Vec3 y = (x - data.centre) * data.inverse_scale;
      Vec3 f;
      scalar_evaluate(n, positions.data(), coefficients.data(), y.data(), f.data());
      return f;
    };
    beside_scalar(model, scalar, at, m);
  }

  // r^5 on force and stiffness, quadratic p.
  void time_hermite(const Model& model, const std::vector<Vec3>& at, Measured& m) {
    const ModelData& data = model.data();
    const std::size_t n = m.n;
    std::vector<double> centres(15 * n), polynomial(30);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < 15; ++k) centres[15 * i + k] = data.data[k * data.stride + i];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t t = 0; t < 10; ++t) polynomial[10 * c + t] = data.polynomial[t][c];
    beside_scalar(
        model,
        [&](const Vec3& x) {
          const Vec3 y = (x - data.centre) * data.inverse_scale;
          Vec3 f;
          scalar_evaluate_hermite(n, centres.data(), polynomial.data(), y.data(), f.data());
          return f;
        },
        at, m);
  }

  template <class Scalar>
  void beside_scalar(const Model& model, const Scalar& scalar, const std::vector<Vec3>& at, Measured& m) {
    constexpr int repeats = 400;
    std::vector<double> ours, theirs;
    double apart = 0;
    for (const Vec3& x : at)
      apart = std::max(apart, (scalar(x) - model.force(x)).norm() / model.force_bound());
    if (!(apart < 1e-9))
      warn(globals_,
           fmt::format("evaluate {} with {}: the scalar baseline gives another force", m.method, m.n));
    for (int block = 0; block < 25 * blocks;
         ++block) {  // in turn, so that both meet what else the machine does
      ours.push_back(evaluation([&](const Vec3& x) { return model.force(x); }, at, repeats));
      theirs.push_back(evaluation(scalar, at, repeats));
    }
    m.evaluate = median(ours);
    row("evaluate", m, "scalar -O2", ours, theirs, std::nullopt);
  }

  void row(const std::string& what, const Measured& m, const char* baseline, const std::vector<double>& ours,
           const std::vector<double>& theirs, std::optional<std::size_t> k, double by_refit = unknown) {
    const double a = median(ours), b = median(theirs);
    Json r;
    r["name"] = what + " " + m.method;
    r["baseline"] = baseline;
    r["ratio"] = number(b / a);
    r["ours_us"] = number(a);
    r["baseline_us"] = number(b);
    r["error"] = {
        {"p50", number(m.inside.p50)}, {"p95", number(m.inside.p95)}, {"max", number(m.inside.max)}};
    r["n"] = m.n;
    r["k"] = k ? Json(*k) : Json(nullptr);
    r["by_refit"] = number(by_refit);
    r["scene"] = case_.name;
    r["law"] = name(case_.body->material.law);
    r["elements"] = case_.body->mesh.tets.size();
    r["threads"] = 1;
    r["tolerance"] = 1e-9;
    rows.push_back(r);
    lines_.push_back(fmt::format("{:18} {:4} {:>3} {:10.3f} {:>26} {:10.3f} {:7.2f} {:9.1e} {:9.1e} {:>8}",
                                 r["name"].get<std::string>(), m.n, k ? std::to_string(*k) : "-", a, baseline,
                                 b, b / a, m.inside.p50, m.inside.p95,
                                 std::isfinite(by_refit) ? fmt::format("{:.0f} %", 100 * by_refit) : "-"));
  }

 public:
  void print() const {
    say(globals_, fmt::format("{}: {} states, {} instructions, one thread; medians\n", case_.name,
                              space_.size(), name(approx_instruction_set())));
    say(globals_, fmt::format("{:18} {:>4} {:>3} {:>10} {:>26} {:>10} {:>7} {:>9} {:>9} {:>8}", "", "n", "k",
                              "ours us", "baseline", "us", "ratio", "error p50", "p95", "by refit"));
    for (const std::string& line : lines_) say(globals_, line);
    say(globals_,
        "evaluate: three force components on n centres and the polynomial (r3 linear, hermite-r5 quadratic), "
        "from a "
        "position in metres; ours with the check of its bound, the baseline centre by centre. update, refit: "
        "from the states to the "
        "coefficients, three right-hand sides; ours with the tangent and bound of the model. by refit: "
        "updates that the updater made by a refit, as it does where that is cheaper.");
    std::string head;
    for (const auto& plane : case_.outside) head += fmt::format(" {:>8.0f} mm", 1e3 * plane.distance);
    say(globals_,
        fmt::format("\n{:13} {:>4} | us: refit  k = 1      5     20  evaluate | inside p50      p95      "
                    "max | outside p50:{} | states for 1 %, 7 %",
                    "method", "n", head));
    for (const Measured& m : table) say(globals_, table_line(m));
    say(globals_,
        "inside: within the lattice. outside: of the half up to the front, at the given distance beyond it. "
        "states: the "
        "fewest, of the lattice and of every second, third, fourth and sixth of its planes, whose p95 is "
        "below that; at "
        "the same inside positions, also where a thinned lattice ends before them.");
  }

 private:
  static std::string short_number(double value, int width) {
    return std::isfinite(value) ? fmt::format("{:{}.3g}", value, width) : fmt::format("{:>{}}", "-", width);
  }

  std::string table_line(const Measured& m) const {
    std::string line =
        fmt::format("{:13} {:4} |   {} {} {} {} {:>9} |", m.method, m.n, short_number(m.refit, 7),
                    short_number(m.update[0], 6), short_number(m.update[1], 6), short_number(m.update[2], 6),
                    short_number(m.evaluate, 9));
    line += fmt::format(" {:10.1e} {:8.1e} {:8.1e} |            ", m.inside.p50, m.inside.p95, m.inside.max);
    for (const Errors& e : m.outside)
      line += std::isfinite(e.p50) ? fmt::format("    {:7.1e}", e.p50) : fmt::format("{:>11}", "-");
    line += " |";
    for (const auto& states : {m.states_for_1, m.states_for_7})
      line += fmt::format(" {:>5}", states ? std::to_string(*states) : "-");
    return line;
  }

  const Globals& globals_;
  Progress& progress_;
  Case case_;
  StateSpace space_;
  std::vector<State> half_;
  std::optional<StateSpace> half_space_;
  std::vector<Sparser> sparser_;
  std::vector<Sample> pool_;
  std::vector<std::string> lines_;
};

Json errors_json(const Errors& e) {
  return {{"p50", number(e.p50)}, {"p95", number(e.p95)}, {"max", number(e.max)}};
}

Json methods_json(const Case& taken, const std::vector<Measured>& table) {
  Json all = Json::array();
  for (const Measured& m : table) {
    Json one;
    one["method"] = m.method;
    one["n"] = m.n;
    one["refit_us"] = number(m.refit);
    for (std::size_t t = 0; t < 3; ++t)
      one["update_us"]["k" + std::to_string(replacements[t])] = number(m.update[t]);
    one["evaluate_us"] = number(m.evaluate);
    one["error"] = errors_json(m.inside);
    for (std::size_t p = 0; p < m.outside.size(); ++p)
      one["outside"][fmt::format("mm{:.0f}", 1e3 * taken.outside[p].distance)] = errors_json(m.outside[p]);
    one["states_for_1_percent"] = m.states_for_1 ? Json(*m.states_for_1) : Json(nullptr);
    one["states_for_7_percent"] = m.states_for_7 ? Json(*m.states_for_7) : Json(nullptr);
    all.push_back(std::move(one));
  }
  return all;
}

void write_folder(const Globals& globals, const std::string& folder, const Case& taken,
                  const std::vector<Measured>& table) {
  const std::filesystem::path at(folder);
  const auto write = [&](const char* file, const std::string& text) {
    OutputFile out(at / file);
    out.write(text);
    out.commit();
  };
  write("approx.csv", table_csv(taken, table));
  if (const auto picture = draw_svg("approx", 1200, 560, pareto_plot(table)))
    write("approx.svg", *picture);
  else
    warn(globals, "gnuplot is missing or failed: no picture");
}

}  // namespace

int bench_approx(const Globals& globals, const std::string& scene, const std::string& folder) {
  scene.empty() ? built_in_scene(globals.set)
                : load_scene(scene, globals.set);  // a bad one leaves no folder behind
  if (!folder.empty()) {
    std::error_code failed;
    const bool there = std::filesystem::exists(folder, failed);
    std::filesystem::create_directories(folder, failed);
    if (!std::filesystem::is_directory(folder, failed))
      throw InputError(folder, there ? "is a file, expected a folder for approx.csv and approx.svg"
                                     : "cannot be made, expected a folder for approx.csv and approx.svg");
    check_writable(std::filesystem::path(folder) / "approx.csv");
  }
  Json document;
  {
    Progress progress(globals, "bench approx");
    Bench bench(globals, take_case(globals, scene, progress), progress);
    bench.run();
    bench.print();
    if (!folder.empty()) write_folder(globals, folder, bench.the_case(), bench.table);
    document["rows"] = bench.rows;
    document["methods"] = methods_json(bench.the_case(), bench.table);
    document["notes"] = bench.notes;
    for (const std::string& note : bench.notes) warn(globals, note);
    if (bench.rows.empty()) warn(globals, "no row could be measured: too few states");
  }
  document["instruction_set"] = name(approx_instruction_set());
  document["provenance"] = provenance("");
  if (globals.json) print_json(document);
  return document["rows"].empty() ? 1 : 0;
}

}  // namespace forefeel
