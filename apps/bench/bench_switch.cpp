// forefeel-bench switch [SCENE]: the cost of a frame under each switch rule and without a switch, and what
// the hand feels if the model changes every 10 to 100 ms. All rules get the same stream of models, a hard
// one: the HIP moves through the scene's box at hand speed, and each model is made from 24 other states of
// the lattice (r^3 on force, as in the paper), so that it differs from the last model everywhere. The first
// model fades in for one second without successors; measurement starts after that. Errors are those of the
// rendered force against the finest model of all states.
//   frames_over_jnd   frames in which the switch exceeds the bound of its rule (none: bound of smooth)
//   max_jump          largest change of the force by the switch in one frame [N]
//   drift             largest change of the force by switches within 50, 100, 300 ms, |sum of dF| [N]
//   delay             time from a model's arrival until the force is its own or a newer one's, and the bound:
//       paper    10 ms (steps of the switch under way + steps of the next + 2), steps = d / s, d the largest
//                difference of the two models at the HIP meanwhile
//       smooth   1 ms (e / s + 1), e the offset plus all that later models add
//       s the least step that the rule allows meanwhile: max(10 mN, 0.07 / 1.07 |F|), a tenth for smooth

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "approx/switch/force_switch.hpp"
#include "apps/bench/bench.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/laboratory.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

constexpr double frame = 1e-3, speed = 0.06;            // [s], [m/s]
constexpr std::size_t frames = 5000, settling = 60000;  // of the stream; at most, after its end
constexpr std::size_t lead = 1000;                      // frames with the first model alone
constexpr std::size_t states_per_model = 24;
constexpr int rounds = 7;
constexpr std::size_t error_every = 10;  // frames

// The input: HIP positions, and new models in some frames.
struct Stream {
  std::vector<Vec3> at;            // by frame
  std::vector<Model> models;       // by growing serial
  std::vector<std::size_t> comes;  // frame of each model
  std::vector<Vec3> truth;         // every error_every frames [N]
};

std::vector<Vec3> motion(const StateSpaceOptions& options) {
  const Vec3 half = 0.4 * options.box.size(), middle = options.box.centre();
  const auto at = [&](double u) {
    return Vec3(middle + half.cwiseProduct(Vec3(std::sin(2 * u), std::sin(3 * u + 0.5), std::sin(u + 1))));
  };
  std::vector<Vec3> path;
  double u = 0;
  while (path.size() < frames) {
    path.push_back(at(u));
    u += speed * frame / std::max(1e-6, (at(u + 1e-5) - at(u)).norm() / 1e-5);
  }
  return path;
}

Stream make_stream(const StateSpaceOptions& options, const std::vector<State>& states, std::size_t every,
                   std::uint64_t seed) {
  Stream stream;
  stream.at = motion(options);
  const ModelOptions paper{.kernel = Kernel::cubic,
                           .data = Data::force,
                           .neighbours = states_per_model,
                           .select = Select::nearest};
  for (std::size_t k = 0; k < frames; k = k == 0 ? lead : k + every) {
    const std::uint64_t draw = random::mix(seed + 7, stream.models.size());
    std::vector<State> known;
    for (std::size_t i = 0; i < states_per_model && !states.empty(); ++i)
      known.push_back(states[random::mix(draw, i) % states.size()]);
    std::ranges::sort(known, [](const State& a, const State& b) {
      return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
    });
    known.erase(
        std::unique(known.begin(), known.end(), [](const State& a, const State& b) { return a.at == b.at; }),
        known.end());
    stream.models.push_back(fit_model(known, paper, stream.at[k]));
    stream.comes.push_back(k);
  }
  StateSpace all(options);
  for (const State& state : states) all.insert(state);
  ModelUpdater best(all, {.kernel = Kernel::quintic,
                          .data = Data::force_and_stiffness,
                          .neighbours = std::min<std::size_t>(50, states.size())});
  for (std::size_t k = 0; k < frames; k += error_every)
    stream.truth.push_back(best.model_at(stream.at[k]).force(stream.at[k]));
  return stream;
}

struct Outcome {
  std::size_t over_bound = 0, skipped = 0;
  double max_jump = 0, max_undamped = 0;      // [N]
  std::array<double, 3> drift{};              // [N]
  std::vector<double> errors, delays;         // [1], [s]
  double worst_bound = 0, most_of_bound = 0;  // [s], delay / bound
  bool latest_wins = true;                    // the force ends at the last model's
};

// One model from its arrival until it is rendered.
struct Waiting {
  std::size_t model = 0, frame = 0;  // frame of its arrival
  double offset = 0;                 // smooth: |e| at arrival plus what later models add [N]
};

class Player {
 public:
  Player(const Stream& stream, SwitchRule rule) : stream_(stream), rule_(rule), switch_({.rule = rule}) {}

  Outcome play(double floor) {
    std::size_t next = 0;
    for (std::size_t k = 0; k < frames + settling && (k < frames || !waiting_.empty()); ++k) {
      const bool comes = next < stream_.comes.size() && stream_.comes[next] == k;
      step(k, comes ? &stream_.models[next] : nullptr, next, floor);
      if (comes) ++next;
    }
    out_.latest_wins = waiting_.empty();
    measure_drift();
    return std::move(out_);
  }

 private:
  const Vec3& at(std::size_t k) const { return stream_.at[std::min(k, frames - 1)]; }

  void step(std::size_t k, const Model* comes, std::size_t index, double floor) {
    const ForceSwitch::Step now = switch_.step(comes, at(k));
    before_.push_back((now.force - now.change).norm());
    out_.over_bound += k >= lead && now.change.norm() > now.bound ? 1 : 0;
    if (k >= lead) {
      changes_.push_back(now.change);
      out_.max_jump = std::max(out_.max_jump, now.change.norm());
      out_.max_undamped = std::max(out_.max_undamped, now.undamped_jump);
    }
    if (k >= lead && k < frames && k % error_every == 0) {
      const Vec3& truth = stream_.truth[k / error_every];
      out_.errors.push_back((now.force - truth).norm() / std::max(truth.norm(), floor));
    }
    if (comes != nullptr) {
      for (Waiting& w : waiting_) w.offset += now.undamped_jump;
      waiting_.push_back({index, k, (now.force - now.undamped).norm() + now.change.norm()});
    }
    finish(k, now.force);
  }

  // The newest waiting model whose force is rendered has arrived, and so have all before it.
  void finish(std::size_t k, const Vec3& force) {
    for (std::size_t w = waiting_.size(); w-- > 0;) {
      if ((force - stream_.models[waiting_[w].model].force(at(k))).norm() > 1e-13 * (1 + force.norm()))
        continue;
      for (std::size_t i = 0; i <= w; ++i) note_delay(waiting_[i], k, waiting_[w].model);
      out_.skipped += w;
      rendered_.push_back({k, waiting_[w].model});
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(w) + 1);
      return;
    }
  }

  double largest_difference(const Model* a, const Model& b, std::size_t from, std::size_t to) const {
    double most = 0;
    for (std::size_t k = from; k <= to; ++k)
      most = std::max(most, ((a != nullptr ? a->force(at(k)) : Vec3::Zero()) - b.force(at(k))).norm());
    return most;
  }

  // The least step in these frames of a rule with this floor and share [N].
  double least_step(double floor, double share, std::size_t from, std::size_t to) const {
    const double force = *std::min_element(before_.begin() + static_cast<std::ptrdiff_t>(from),
                                           before_.begin() + static_cast<std::ptrdiff_t>(to) + 1);
    return std::max(floor, share / (1 + share) * force) * (1 - 1e-6);
  }

  double paper_steps(const Model* a, std::size_t b, std::size_t from, std::size_t to) const {
    return std::ceil(largest_difference(a, stream_.models[b], from, to) / least_step(10e-3, 0.07, from, to)) +
           1;
  }

  double bound_of(const Waiting& w, std::size_t done, std::size_t arrived) const {
    if (rule_ == SwitchRule::none) return 0;
    if (rule_ == SwitchRule::smooth)
      return frame * (std::ceil(w.offset / least_step(1e-3, 0.007, w.frame, done)) + 1);
    // If a switch A -> B was under way at its arrival, B -> C (it or a newer model) followed; else A -> C
    // alone.
    double steps = 0;
    const Model* before = nullptr;
    std::size_t since = 0;
    for (const auto& [k, model] : rendered_) {
      if (k >= w.frame) steps += paper_steps(before, model, since, k);
      since = k;
      before = &stream_.models[model];
    }
    return 10e-3 * (steps + paper_steps(before, arrived, since, done));
  }

  void note_delay(const Waiting& w, std::size_t k, std::size_t arrived) {
    if (w.frame < lead) return;
    const double delay = frame * static_cast<double>(k - w.frame), bound = bound_of(w, k, arrived);
    out_.delays.push_back(delay);
    out_.worst_bound = std::max(out_.worst_bound, bound);
    if (bound > 0)
      out_.most_of_bound = std::max(out_.most_of_bound, delay / bound);
    else if (delay > 0)
      out_.most_of_bound = std::numeric_limits<double>::infinity();
  }

  void measure_drift() {
    const std::array<std::size_t, 3> windows{50, 100, 300};
    for (std::size_t i = 0; i < windows.size(); ++i) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t k = 0; k < changes_.size(); ++k) {
        sum += changes_[k];
        if (k >= windows[i]) sum -= changes_[k - windows[i]];
        out_.drift[i] = std::max(out_.drift[i], sum.norm());
      }
    }
  }

  const Stream& stream_;
  SwitchRule rule_;
  ForceSwitch switch_;
  Outcome out_;
  std::vector<Vec3> changes_;
  std::vector<double> before_;  // |F| before each frame's change [N]
  std::deque<Waiting> waiting_;
  std::vector<std::pair<std::size_t, std::size_t>> rendered_;  // frame, model of each finished switch
};

// Time of one pass over the stream with only the switch in it [us per frame].
double cost_of_a_frame(const Stream& stream, SwitchRule rule) {
  ForceSwitch damped({.rule = rule});
  Vec3 sum = Vec3::Zero();
  std::size_t next = 0;
  const double start = now_us();
  for (std::size_t k = 0; k < frames; ++k) {
    const bool comes = next < stream.comes.size() && stream.comes[next] == k;
    sum += damped.step(comes ? &stream.models[next] : nullptr, stream.at[k]).force;
    next += comes ? 1 : 0;
  }
  const double took = now_us() - start;
  return sum.allFinite() ? took / static_cast<double>(frames) : unknown;
}

struct SwitchRow {
  SwitchRule rule;
  std::size_t every;  // [ms]
  const Outcome& found;

  double delay_ms(double share) const { return 1e3 * quantile_of(found.delays, share); }
};

const JsonKeys<SwitchRow>& switch_keys() {
  using R = SwitchRow;
  static const JsonKeys<R> keys{
      {"rule", "", "bench switch: paper, smooth or none", [](const R& r) { return name(r.rule); }},
      {"update_ms", "ms", "a new model this often", &R::every},
      {"frames", "", "played", [](const R&) { return frames - lead; }},
      {"frames_over_jnd", "", "whose change exceeds the rule's bound",
       [](const R& r) { return r.found.over_bound; }},
      {"max_jump", "N", "largest change in a frame", [](const R& r) { return r.found.max_jump; }},
      {"max_jump_undamped", "N", "between two models", [](const R& r) { return r.found.max_undamped; }},
      {"drift.ms50,ms100,ms300", "N", "change within so many ms",
       [](const R& r) {
         return json_numbers({r.found.drift.begin(), r.found.drift.end()});
       }},
      {"delay.p50_ms,p95_ms,max_ms", "ms", "until a new model is fully there",
       [](const R& r) {
         return json_numbers({r.delay_ms(0.5), r.delay_ms(0.95), r.delay_ms(1)});
       }},
      {"delay.bound_ms", "ms", "its bound", [](const R& r) { return 1e3 * r.found.worst_bound; }},
      {"delay.most_of_bound", "1", "largest delay over its bound",
       [](const R& r) { return r.found.most_of_bound; }},
      {"delay.within_bound", "", "true: never above it",
       [](const R& r) { return r.found.most_of_bound <= 1; }},
      {"models_skipped", "", "models that a newer one replaced", [](const R& r) { return r.found.skipped; }},
      {"latest_wins", "", "true: the newest model always wins",
       [](const R& r) { return r.found.latest_wins; }}};
  return keys;
}

const JsonKeys<BenchEnd>& model_keys() {
  static const JsonKeys<BenchEnd> keys{
      {"model", "", "that is switched",
       [](const BenchEnd&) { return fmt::format("r3, force, {} random states each", states_per_model); }}};
  return keys;
}

Json make_row(const Laboratory& laboratory, SwitchRule rule, std::size_t every, double ours, double none,
              const Outcome& found) {
  Json row = row_json({.name = fmt::format("switch {}, update every {} ms", name(rule), every),
                       .baseline = "rule none",
                       .ours_us = ours,
                       .baseline_us = none,
                       .error = p50_p95_max(found.errors),
                       .n = states_per_model},
                      {.scene = laboratory.name(), .body = laboratory.scene().body.get(), .tolerance = 1e-9});
  add_to(row, switch_keys(), {rule, every, found});
  return row;
}

}  // namespace

DeclaredTable declared_bench_switch() {
  return bench_table("switch", {declared(instruction_set_keys()), below("rows[]", declared(switch_keys())),
                                declared(model_keys())});
}

int bench_switch(const Globals& globals, const std::string& scene) {
  Laboratory laboratory(globals, scene);
  Progress progress(globals, "bench switch");
  const StateSpaceOptions& space = laboratory.scene().space;
  const std::vector<State> states = laboratory.lattice_states(
      space.box, space.spacing,
      [&](double share, const std::string& text) { progress.show(0.5 * share, text); });
  constexpr std::array rules{SwitchRule::smooth, SwitchRule::paper, SwitchRule::none};
  Json document{{"rows", Json::array()}};
  bool good = true;
  std::vector<std::string> lines;
  for (const std::size_t every : {10u, 20u, 50u, 100u}) {
    progress.show(0.5 + 0.005 * static_cast<double>(every - 10), fmt::format("a model every {} ms", every));
    const Stream stream = make_stream(space, states, every, globals.seed);
    std::array<std::vector<double>, 3> costs;
    for (int round = 0; round < rounds; ++round)  // in turns, so that other load affects all alike
      for (std::size_t r = 0; r < rules.size(); ++r) costs[r].push_back(cost_of_a_frame(stream, rules[r]));
    const double none = quantile_of(costs[2], 0.5);
    for (std::size_t r = 0; r < rules.size(); ++r) {
      const Outcome found = Player(stream, rules[r]).play(laboratory.scene().session.judging.error_floor);
      const double ours = quantile_of(costs[r], 0.5);
      document["rows"].push_back(make_row(laboratory, rules[r], every, ours, none, found));
      if (rules[r] != SwitchRule::none)
        good = good && found.over_bound == 0 && found.most_of_bound <= 1 && found.latest_wins;
      lines.push_back(fmt::format(
          "{:7} every {:3} ms: {:.3f} us a frame (none {:.3f}, ratio {:.2f}); {:4} frames over the bound, "
          "largest change {:.3g} N (models {:.3g} N), "
          "drift in 100 ms {:.3g} N; delay p95 {:.0f}, most {:.0f} ms (bound {:.0f}); error p95 {:.2g}",
          name(rules[r]), every, ours, none, none / ours, found.over_bound, found.max_jump,
          found.max_undamped, found.drift[1], 1e3 * quantile_of(found.delays, 0.95),
          1e3 * quantile_of(found.delays, 1), 1e3 * found.worst_bound, quantile_of(found.errors, 0.95)));
    }
  }
  const BenchEnd end{laboratory.scene().source.hash};
  for (const JsonKeys<BenchEnd>& keys : {model_keys(), instruction_set_keys(), provenance_keys()})
    add_to(document, keys, end);
  if (globals.json) print_json(document);
  for (const std::string& line : lines) say(globals, line);
  if (good) return 0;
  warn(globals,
       "a rule broke its bound on the change of force, on its delay, or did not end on the latest model");
  return 1;
}

}  // namespace forefeel
