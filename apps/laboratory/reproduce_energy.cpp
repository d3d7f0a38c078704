// Energy around closed loops (approx/error/loop_energy.hpp) in the scene's own state space, per method:
//   fixed    one set of states: the nearest to the middle of the loop, or the set that an older method uses
//   moving   the set follows the HIP; a new model every quarter spacing, used at once
//   smooth   as moving, through the default switch. Left out if the switch passes every change of model in one frame:
//            then nothing is damped, and the forces are the same.
// Moving loops run twice. Only the second turn counts, because the first model fades in during the first.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "approx/error/loop_energy.hpp"
#include "approx/methods/older_methods.hpp"
#include "approx/switch/force_switch.hpp"
#include "apps/console/json.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/placement/placement_energy.hpp"

namespace forefeel {
namespace {

constexpr std::size_t points = 4000;  // per loop
constexpr std::size_t places = 4;
constexpr double small = 1.2, large = 2.5;  // half axes of fixed and moving loops, in spacings
constexpr std::size_t most_in_one = 4000;   // limit of states in the offline-rbf model, whose cost is cubic
constexpr double quarter = 0.25;            // travel after which a new model is made, in spacings

struct EnergyRow {
  std::string method, set;
  double half_axis = 0;        // the larger of its loops, in spacings
  std::vector<double> ratios;  // net / gross of each loop
};

std::vector<Vec3> centres(const StateSpaceOptions& space) {
  std::vector<Vec3> all;
  const Vec3 room = (0.5 * space.box.size() - Vec3::Constant(large * space.spacing)).cwiseMax(0);
  for (std::uint64_t p = 0; p < places; ++p) {
    Vec3 centre = space.box.centre();
    for (unsigned d = 0; d < 3; ++d)
      centre[d] += 0.8 * room[d] * (2 * random::uniform(random::mix(77, 3 * p + d)) - 1);
    all.push_back(centre);
  }
  return all;
}

// Loops around places of the box, each in three planes.
std::vector<std::vector<Vec3>> loops(const StateSpaceOptions& space, double radius) {
  std::vector<std::vector<Vec3>> all;
  const double a = radius * space.spacing;
  for (const Vec3& centre : centres(space)) {
    all.push_back(ellipse(centre, a * Vec3::UnitX(), 0.8 * a * Vec3::UnitY(), points));
    all.push_back(ellipse(centre, a * Vec3::UnitY(), 0.8 * a * Vec3::UnitZ(), points));
    all.push_back(
        ellipse(centre, a * Vec3(1, 1, 0).normalized(), 0.8 * a * Vec3(1, -1, 1).normalized(), points));
  }
  return all;
}

Vec3 middle(const std::vector<Vec3>& loop) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : loop) sum += x;
  return sum / static_cast<double>(loop.size());
}

std::vector<State> nearest(const StateSpace& space, const Vec3& x, std::size_t n) {
  std::vector<StateId> ids;
  space.nearest(x, n, ids);
  std::vector<State> states;
  for (const StateId id : ids) states.push_back(space[id]);
  return states;
}

struct Kind {
  std::string name;
  ModelOptions model;
};
std::vector<Kind> kinds(std::size_t known) {
  const auto plain = [&](Kernel kernel) {
    return ModelOptions{
        .kernel = kernel, .data = Data::force, .neighbours = std::min<std::size_t>(100, known)};
  };
  const auto hermite = [&](Kernel kernel) {
    return ModelOptions{
        .kernel = kernel, .data = Data::force_and_stiffness, .neighbours = std::min<std::size_t>(25, known)};
  };
  return {{"r, n 100", plain(Kernel::linear)},
          {"r3, n 100", plain(Kernel::cubic)},
          {"r5, n 100", plain(Kernel::quintic)},
          {"Hermite r3, n 25", hermite(Kernel::cubic)},
          {"Hermite r5, n 25", hermite(Kernel::quintic)}};
}

// The force that a moving HIP feels: the model is updated every quarter spacing.
class Moving {
 public:
  Moving(const StateSpace& space, const ModelOptions& options, SwitchRule rule)
      : updater_(space, options), switch_({.rule = rule}), travel_(quarter * space.options().spacing) {
    for (Model& model : models_) model.reserve(options);
  }
  Vec3 operator()(const Vec3& x) {
    const Model* newest = nullptr;
    if (!started_ || (x - updated_at_).norm() >= travel_) {
      next_ = (next_ + 1) % 4;  // the switch holds at most two
      updater_.update(x, models_[next_]);
      newest = &models_[next_];
      updated_at_ = x;
      started_ = true;
    }
    const ForceSwitch::Frame frame = switch_.step(newest, x);
    if (frame.took_model) largest_ = std::max(largest_, frame.undamped_jump / frame.bound);
    damped_ += frame.force != frame.undamped ? 1 : 0;
    return frame.force;
  }
  void count_from_here() { damped_ = 0, largest_ = 0; }
  std::size_t damped() const { return damped_; }  // frames whose force differs from the newest model's
  double largest() const { return largest_; }     // jump between models, relative to the bound of one frame

 private:
  ModelUpdater updater_;
  ForceSwitch switch_;
  std::array<Model, 4> models_;
  double travel_;
  Vec3 updated_at_ = Vec3::Zero();
  std::size_t next_ = 0, damped_ = 0;
  double largest_ = 0;
  bool started_ = false;
};

void fixed_rows(const StateSpace& space, const std::vector<State>& states, std::vector<EnergyRow>& rows,
                std::vector<std::string>& notes) {
  const auto all = loops(space.options(), small);
  for (const Kind& kind : kinds(space.size())) {
    EnergyRow row{kind.name, "fixed", small, {}};
    for (const auto& loop : all) {
      const Model model =
          fit_model(nearest(space, middle(loop), kind.model.neighbours), kind.model, middle(loop));
      row.ratios.push_back(loop_energy(loop, [&](const Vec3& x) { return model.force(x); }).ratio());
    }
    rows.push_back(std::move(row));
  }
  EnergyRow row{"energy interpolant, n 25", "fixed", small, {}};
  for (const auto& loop : all) {
    const std::vector<State> set = nearest(space, middle(loop), 25);
    std::vector<const State*> pointers;
    for (const State& s : set) pointers.push_back(&s);
    if (const auto field = EnergyInterpolant::fit(pointers, 3))
      row.ratios.push_back(loop_energy(loop, [&](const Vec3& x) { return field->force(x); }).ratio());
  }
  rows.push_back(std::move(row));
  for (const Method method : all_methods()) {
    if (method == Method::rbf) continue;  // above
    if (method == Method::offline_rbf && states.size() > most_in_one) {
      notes.push_back(fmt::format("{}: left out, {} states are too many for one model (at most {})",
                                  name(method), states.size(), most_in_one));
      continue;
    }
    try {
      const Approximation field(
          method, states,
          {.model = {.kernel = Kernel::cubic, .data = Data::force, .length = space.options().spacing},
           .spacing = space.options().spacing,
           .centres = 0});
      EnergyRow older{std::string(name(method)), "fixed", large, {}};
      for (const auto& loop : loops(space.options(), large))
        older.ratios.push_back(loop_energy(loop, [&](const Vec3& x) { return field.force(x); }).ratio());
      rows.push_back(std::move(older));
    } catch (const InputError& error) {  // the method cannot use these states
      notes.push_back(fmt::format("{}: left out, {}", name(method), error.what()));
    }
  }
}

// Effect of the switch on the second turns of all moving loops.
struct Damping {
  std::size_t frames = 0, damped = 0;
  double largest = 0;  // jump between models, relative to the bound of one frame
};

Damping moving_rows(const StateSpace& space, std::vector<EnergyRow>& rows) {
  Damping damping;
  std::vector<EnergyRow> smooth;
  for (const SwitchRule rule : {SwitchRule::none, SwitchRule::smooth})
    for (const Kind& kind : kinds(space.size())) {
      EnergyRow row{kind.name, rule == SwitchRule::none ? "moving" : "moving, smooth switch", large, {}};
      for (const auto& loop : loops(space.options(), large)) {
        Moving field(space, kind.model, rule);
        for (const Vec3& x : loop) field(x);
        field.count_from_here();
        row.ratios.push_back(loop_energy(loop, [&](const Vec3& x) { return field(x); }).ratio());
        if (rule == SwitchRule::none) continue;
        damping.frames += loop.size();
        damping.damped += field.damped();
        damping.largest = std::max(damping.largest, field.largest());
      }
      (rule == SwitchRule::none ? rows : smooth).push_back(std::move(row));
    }
  if (damping.damped > 0) rows.insert(rows.end(), smooth.begin(), smooth.end());
  return damping;
}

Figure picture(const std::vector<EnergyRow>& rows) {
  std::vector<std::string> sets;
  for (const EnergyRow& row : rows)
    if (std::ranges::find(sets, row.set) == sets.end()) sets.push_back(row.set);
  std::vector<std::string> names;
  for (const EnergyRow& row : rows)
    if (std::ranges::find(names, row.method) == names.end()) names.push_back(row.method);
  std::string script, tics, plot;
  for (std::size_t i = 0; i < names.size(); ++i)
    tics += fmt::format("{}'{}' {}", i > 0 ? ", " : "", names[i], names.size() - i);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    std::string lines;
    for (const EnergyRow& row : rows)
      if (row.set == sets[s])
        for (std::size_t i = 0; i < names.size(); ++i)
          if (names[i] == row.method)
            lines += fmt::format("{:.4g} {} {:.4g} {:.4g}\n", std::max(1e-17, quantile_of(row.ratios, 0.5)),
                                 static_cast<double>(names.size() - i) + 0.22 * (1 - static_cast<double>(s)),
                                 std::max(1e-17, quantile_of(row.ratios, 0)),
                                 std::max(1e-17, quantile_of(row.ratios, 1)));
    script += data_block(fmt::format("e{}", s), lines);
    plot += fmt::format("{}$e{} using 1:2:3:4 with xerrorbars pt {} ps 0.9 lw 1.6 lc rgb '{}' title '{}'",
                        s > 0 ? ", " : "plot ", s,
                        s == 0   ? 7
                        : s == 1 ? 5
                                 : 9,
                        line_colour(s == 0   ? 1
                                    : s == 1 ? 0
                                             : 2),
                        sets[s]);
  }
  script += plot_style;
  script += fmt::format(
      "set logscale x\nset xrange [1e-17:1]\nset format x '10^{{%T}}'\nset xlabel 'energy lost or gained "
      "around a loop / energy moved (net / gross)'\n"
      "set yrange [0.4:{}]\nset ytics ({}) noenhanced\nset key outside top center horizontal samplen 1\n{}\n",
      static_cast<double>(names.size()) + 0.6, tics, plot);
  return {
      "energy",
      fmt::format("Median over {} loops; bars from least to largest. The table has the sizes of the loops.",
                  3 * places),
      960, 90 + 36 * static_cast<int>(names.size()), script};
}

// ---- output

struct EnergyFindings {
  StateSpaceOptions space = {};
  std::size_t states = 0;
  std::vector<EnergyRow> rows = {};
  std::vector<std::string> notes = {};
  Damping damping = {};

  // Statistic of net / gross energy of a row; unknown if there is no such row.
  double median(std::string_view method, std::string_view set) const {
    for (const EnergyRow& row : rows)
      if (row.method == method && row.set == set) return quantile_of(row.ratios, 0.5);
    return unknown;
  }
};

// Number of loops that leave the box.
std::size_t loops_beyond(const StateSpaceOptions& space) {
  std::size_t beyond = 0;
  for (const double radius : {small, large})
    for (const auto& loop : loops(space, radius)) {
      const bool inside = std::ranges::all_of(loop, [&](const Vec3& x) {
        return ((x - space.box.low).array() >= -1e-12).all() &&
               ((space.box.high - x).array() >= -1e-12).all();
      });
      beyond += inside ? 0 : 1;
    }
  return beyond;
}

std::string csv_of(const EnergyFindings& found) {
  std::string csv = "method,set,half_axis,loops,net_over_gross_p50,net_over_gross_max\n";
  for (const EnergyRow& row : found.rows)
    csv += fmt::format("\"{}\",\"{}\",{:.6g},{},{:.4g},{:.4g}\n", row.method, row.set,
                       row.half_axis * found.space.spacing, row.ratios.size(), quantile_of(row.ratios, 0.5),
                       quantile_of(row.ratios, 1));
  return csv;
}

std::string table_of(const EnergyFindings& found) {
  std::vector<std::vector<std::string>> cells{
      {"method", "set", "half axes of the loops", "net / gross, median", "most"}};
  const double h = found.space.spacing;
  for (const EnergyRow& row : found.rows)
    cells.push_back({row.method, row.set,
                     fmt::format("{:.3g}, {:.3g} mm", 1e3 * row.half_axis * h, 800 * row.half_axis * h),
                     fmt::format("{:.2g}", quantile_of(row.ratios, 0.5)),
                     fmt::format("{:.2g}", quantile_of(row.ratios, 1))});
  return html_table(cells);
}

nlohmann::ordered_json summary_of(const EnergyFindings& found) {
  const double h = found.space.spacing;
  const auto axes_of = [&](double radius) { return nlohmann::ordered_json{radius * h, 0.8 * radius * h}; };
  nlohmann::ordered_json summary;
  summary["loops"] = {{"points", points},
                      {"half_axes_small", axes_of(small)},
                      {"half_axes_large", axes_of(large)},
                      {"planes", {"x, y", "y, z", "(1, 1, 0), (1, -1, 1)"}},
                      {"beyond_the_box", loops_beyond(found.space)},
                      {"centres", nlohmann::ordered_json::array()}};
  for (const Vec3& c : centres(found.space)) summary["loops"]["centres"].push_back(vector3(c));
  summary["notes"] = found.notes;
  summary["states"] = found.states;
  summary["switch"] = {{"frames", found.damping.frames},
                       {"damped", found.damping.damped},
                       {"largest_jump_over_bound", number(found.damping.largest)}};
  summary["rows"] = nlohmann::ordered_json::array();
  for (const EnergyRow& row : found.rows)
    summary["rows"].push_back({{"method", row.method},
                               {"set", row.set},
                               {"loops", row.ratios.size()},
                               {"half_axes", axes_of(row.half_axis)},
                               {"p50", number(quantile_of(row.ratios, 0.5))},
                               {"max", number(quantile_of(row.ratios, 1))}});
  return summary;
}

std::string through_the_switch(const EnergyFindings& found) {
  const Damping& damping = found.damping;
  if (damping.damped == 0)
    return fmt::format(
        "through the smooth switch exactly the same forces: consecutive models differ by at most {:.2g} % of "
        "what it lets pass in one frame, so it had nothing to damp.",
        100 * damping.largest);
  const char* const set = "moving, smooth switch";
  return fmt::format(
      "through the smooth switch, which damped {:.2g} % of the frames, {:.1g}, {:.1g} and {:.1g}.",
      100 * static_cast<double>(damping.damped) / static_cast<double>(damping.frames),
      found.median("Hermite r5, n 25", set), found.median("r3, n 100", set), found.median("r, n 100", set));
}

std::string what_we_found(const EnergyFindings& found) {
  const double h = found.space.spacing;
  std::string where;
  for (const Vec3& c : centres(found.space))
    where += fmt::format("{}({:.3g}, {:.3g}, {:.3g})", where.empty() ? "" : ", ", 1e3 * c[0], 1e3 * c[1],
                         1e3 * c[2]);
  const std::size_t beyond = loops_beyond(found.space);
  std::string text = fmt::format(
      "Medians of net over gross energy. {} loops each: ellipses in three planes around ({}) mm{}. Half "
      "axes: {:.3g} and {:.3g} mm for models of a fixed set, {:.3g} and {:.3g} mm for moving sets and for "
      "the older "
      "methods, which know all states. On a fixed set: an interpolant of the energy {:.1g}, Hermite r5 "
      "{:.1g}, "
      "r3 {:.1g}, r {:.1g}; older methods: trilinear cells {:.1g}, one r3 model of all states {:.1g}. If the "
      "set moves with the HIP and models are used at once: Hermite r5 {:.1g}, r3 {:.1g}, r {:.1g}; {}",
      3 * places, where, beyond > 0 ? fmt::format(" ({} of {} go beyond the box)", beyond, 6 * places) : "",
      1e3 * small * h, 800 * small * h, 1e3 * large * h, 800 * large * h,
      found.median("energy interpolant, n 25", "fixed"), found.median("Hermite r5, n 25", "fixed"),
      found.median("r3, n 100", "fixed"), found.median("r, n 100", "fixed"),
      found.median("trilinear", "fixed"), found.median("offline-rbf", "fixed"),
      found.median("Hermite r5, n 25", "moving"), found.median("r3, n 100", "moving"),
      found.median("r, n 100", "moving"), through_the_switch(found));
  for (const std::string& note : found.notes) text += " " + note + ".";
  return text;
}

}  // namespace

Findings reproduce_energy(Laboratory& laboratory, const ReproduceOptions&,
                          const std::filesystem::path& folder, const ShowShare& show) {
  EnergyFindings found{.space = laboratory.scene().space};
  const std::vector<State> states =
      laboratory.lattice_states(found.space.box, found.space.spacing,
                                [&](double share, const std::string& text) { show(0.5 * share, text); });
  found.states = states.size();
  StateSpace space(found.space);
  for (const State& state : states) space.insert(state);
  show(0.5, "fixed sets");
  fixed_rows(space, states, found.rows, found.notes);
  show(0.7, "moving sets");
  found.damping = moving_rows(space, found.rows);
  write_whole(folder / "energy.csv", csv_of(found));

  Findings findings{.summary = summary_of(found), .html = {}, .lines = {what_we_found(found)}};
  findings.html =
      paragraph("The question",
                "The paper does not study energy. An elastic body returns the energy put into it, so a "
                "force field that gains energy around a closed loop can drive a hand. Not only the "
                "kernel matters, but also the set of states, which moves with the hand.") +
      paragraph("We found", findings.lines.front()) + draw_into(folder, picture(found.rows)) +
      table_of(found);
  return findings;
}

}  // namespace forefeel
