// Times of a model of energy jets in `forefeel-bench approx`.

#include <fmt/format.h>

#include <algorithm>

#include "approx/model/jet_set.hpp"
#include "apps/bench/bench_approx_time.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel::bench {
namespace {

constexpr int blocks = 200, repeats = 400, rounds = 12;

Model hermite_of(const StateSpace& space, const Vec3& centre) {
  ModelOptions options{.kernel = Kernel::quintic, .data = Data::force_and_stiffness};
  options.neighbours = std::min<std::size_t>(25, space.size());
  std::vector<StateId> ids;
  space.nearest(centre, options.neighbours, ids);
  std::vector<Sample> samples;
  for (const StateId id : ids) samples.push_back({id, space[id].at, space[id].force, space[id].stiffness});
  RbfFit fit(options, samples.size());
  fit.refit(samples);
  ModelDraft draft;
  draft.reserve(options);
  fit.write(draft, centre);
  Model model;
  model.assign(draft, 1);
  return model;
}

// Times of `rounds` updates after k more states, from half of the states on.
double update_us(const Case& taken, const ModelOptions& options, std::size_t k) {
  StateSpace space(taken.options);
  std::size_t next = 0;
  while (next < taken.states.size() / 2) space.insert(taken.states[next++]);
  JetSet jets(space, options);
  jets.learn();
  ModelDraft draft;
  draft.reserve(options);
  std::vector<StateId> chosen;
  std::vector<double> times;
  for (int round = 0; round < rounds && next + k <= taken.states.size(); ++round) {
    for (std::size_t i = 0; i < k; ++i) space.insert(taken.states[next++]);
    const double start = now_us();
    jets.learn();
    jets.choose(taken.states[next - 1].at, chosen);
    jets.write(chosen, draft);
    times.push_back(now_us() - start);
  }
  return times.empty() ? unknown : median(times);
}

}  // namespace

void time_jets(const Globals& globals, const Case& taken, const StateSpace& space,
               const ModelOptions& options, Measured& m, std::vector<Comparison>& rows) {
  JetSet jets(space, options);
  jets.learn();
  ModelDraft draft;
  draft.reserve(options);
  std::vector<StateId> chosen;
  std::vector<double> refits;
  std::vector<Vec3> at;
  for (const State& s : taken.inside) at.push_back(s.at);
  for (const Vec3& x : at) {
    const double start = now_us();
    jets.choose(x, chosen);
    jets.write(chosen, draft);
    refits.push_back(now_us() - start);
  }
  m.refit = median(refits);
  for (std::size_t t = 0; t < 3; ++t) m.update[t] = update_us(taken, options, replacements[t]);

  Model model;
  model.assign(draft, 1);
  const Vec3 centre = taken.options.box.centre();
  const Model hermite = hermite_of(space, centre);
  // As in the loop: among the states of the Hermite model, where it costs least.
  for (Vec3& x : at)
    x = centre + 0.5 / (hermite.data().sum.inverse_scale * taken.options.box.size().norm()) * (x - centre);
  const auto force = [](const Model& by) { return [&by](const Vec3& x) { return by.force(x); }; };
  const auto with_stiffness = [](const Model& by) {
    return [&by](const Vec3& x) {
      Vec3 f;
      Mat3 jacobian;
      by.evaluate(x, f, jacobian);
      return Vec3(f + jacobian.col(0));
    };
  };
  const auto pair = [&](const std::string& name, const char* baseline, const auto& of) {
    BenchTimes ours, theirs;
    for (int block = 0; block < blocks; ++block) {  // alternating, so that other load affects both
      ours.add(evaluation_time(globals, of(model), at, repeats));
      theirs.add(evaluation_time(globals, of(hermite), at, repeats));
    }
    rows.push_back({.name = name,
                    .baseline = baseline,
                    .ours = median(ours.wall),
                    .theirs = theirs.median(),
                    .error = m.inside,
                    .n = m.n});
    return median(ours.wall);
  };
  m.evaluate = pair("evaluate jet", "hermite-r5 with 25", force);
  pair("force and K jet", "hermite-r5 with 25", with_stiffness);
}

}  // namespace forefeel::bench
