#include "apps/bench/bench_approx_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "approx/error/error_scale.hpp"
#include "apps/bench/lu_refit.hpp"
#include "apps/bench/scalar_evaluate.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel::bench {
namespace {

constexpr int blocks = 8, per_block = 12;

// One replacement: k of n states of the pool for others.
struct Change {
  std::vector<StateId> removed;
  std::vector<Sample> added, all;
};

class ModelTiming {
 public:
  ModelTiming(const Globals& globals, const Case& taken, const std::vector<Sample>& pool,
              std::vector<Comparison>& rows)
      : globals_(globals), case_(taken), pool_(pool), rows_(rows) {}

  void time_fits(const ModelOptions& options, Measured& m) {
    const std::size_t n = options.neighbours;
    const bool hermite = options.data == Data::force_and_stiffness;
    std::optional<LuRefit> lu;
    if (m.method == "r3" || m.method == "hermite-r5") lu.emplace(n, hermite);
    ModelDraft draft;
    draft.reserve(options);
    double sink = 0;
    RbfFit own(options, n);
    BenchTimes refits, theirs;
    for (std::size_t t = 0; t < 3; ++t) {
      const std::size_t k = replacements[t];
      if (2 * k > n) continue;
      const std::vector<Change> made = changes(n, k);
      BenchTimes updates, own_refits, lu_refits;
      RbfFit fit(options, n);
      fit.refit({pool_.data(), n});
      std::size_t by_refit = 0;  // updates made by a refit, because that is cheaper
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
      m.update[t] = median(updates.wall);
      const double share = double(by_refit) / double(made.size());
      if (lu) row("update", m, "Eigen PartialPivLU refit", updates, lu_refits, k, share);
      row("update", m, "own refit", updates, own_refits, k, share);
      refits.add(own_refits);
      theirs.add(lu_refits);
    }
    m.refit = median(refits.wall);
    if (lu) row("refit", m, "Eigen PartialPivLU refit", refits, theirs, std::nullopt);
    if (!std::isfinite(sink)) warn(globals_, "the LU baseline met a singular system");
  }

  void time_evaluation(const ModelOptions& options, Measured& m) {
    const std::size_t n = options.neighbours;
    RbfFit fit(options, n);
    fit.refit({pool_.data(), n});
    ModelDraft draft;
    fit.write(draft, pool_[0].at);
    Model model;
    model.assign(draft, 1);
    // As in the loop: HIP positions among the states of the model.
    const auto& reference = case_.inside;
    const Vec3 centre = model.data().sum.centre;
    const double shrink = 0.5 / (model.data().sum.inverse_scale * case_.options.box.size().norm());
    std::vector<Vec3> at;
    for (const State& s : reference) at.push_back(centre + shrink * (s.at - case_.options.box.centre()));
    constexpr int repeats = 400;
    std::vector<double> ours;
    const auto own = [&](const Vec3& x) { return model.force(x); };
    if (m.method == "hermite-r5" && model.data().sum.power == 5) return time_hermite(model, at, m);
    if (m.method != "r3") {
      for (int block = 0; block < 4 * blocks; ++block)
        ours.push_back(evaluation_us(globals_, own, at, repeats));
      m.evaluate = median(ours);
      return;
    }
    const ModelData& data = model.data();
    std::vector<double> positions(3 * n), coefficients(3 * n + 12);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < n; ++i) {
        positions[3 * i + c] = data.sum.data[c * data.sum.stride + i];
        coefficients[3 * i + c] = data.sum.data[(3 + c) * data.sum.stride + i];
      }
      for (std::size_t t = 0; t < 4; ++t) coefficients[3 * n + 4 * c + t] = data.sum.polynomial[t][c];
    }
    const auto scalar = [&](const Vec3& x) {
      const Vec3 y = (x - data.sum.centre) * data.sum.inverse_scale;
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
      for (std::size_t k = 0; k < 15; ++k) centres[15 * i + k] = data.sum.data[k * data.sum.stride + i];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t t = 0; t < 10; ++t) polynomial[10 * c + t] = data.sum.polynomial[t][c];
    beside_scalar(
        model,
        [&](const Vec3& x) {
          const Vec3 y = (x - data.sum.centre) * data.sum.inverse_scale;
          Vec3 f;
          scalar_evaluate_hermite(n, centres.data(), polynomial.data(), y.data(), f.data());
          return f;
        },
        at, m);
    if (n <= 25) time_bars(model, at, m);
  }

  // The force with its three error bars, as each frame of the loop evaluates them (scheduling/render/bar_link.hpp),
  // against the force alone. The bars cost the difference.
  void time_bars(const Model& model, const std::vector<Vec3>& at, const Measured& m) {
    constexpr int repeats = 400;
    std::vector<State> states(std::min(m.n, ErrorScale::most));
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].at = pool_[i].at;
      states[i].force = pool_[i].force;
      states[i].stiffness = pool_[i].stiffness;
    }
    const ErrorScale scale(states, case_.options.spacing);
    const Vec3 factors(1.1, 1.6, 3.0);  // any numbers
    const auto barred = [&](const Vec3& x) {
      const Vec3 force = model.force(x);
      const double s = scale.at(x, force), residual = 1e-3 * s;
      return Vec3(std::hypot(factors[0] * s, residual), std::hypot(factors[1] * s, residual),
                  std::hypot(factors[2] * s, residual) + force.sum());
    };
    BenchTimes with, without;
    for (int block = 0; block < 25 * blocks; ++block) {
      with.add(evaluation_time(globals_, barred, at, repeats));
      without.add(evaluation_time(
          globals_, [&](const Vec3& x) { return model.force(x); }, at, repeats));
    }
    row("evaluate with bars", m, "force alone", with, without, std::nullopt);
  }

  template <class Scalar>
  void beside_scalar(const Model& model, const Scalar& scalar, const std::vector<Vec3>& at, Measured& m) {
    constexpr int repeats = 400;
    BenchTimes ours, theirs;
    double apart = 0;
    for (const Vec3& x : at)
      apart = std::max(apart, (scalar(x) - model.force(x)).norm() / model.force_bound());
    if (!(apart < 1e-9))
      warn(globals_,
           fmt::format("evaluate {} with {}: the scalar baseline gives another force", m.method, m.n));
    for (int block = 0; block < 25 * blocks;
         ++block) {  // alternating, so that other load on the machine affects both
      ours.add(evaluation_time(
          globals_, [&](const Vec3& x) { return model.force(x); }, at, repeats));
      theirs.add(evaluation_time(globals_, scalar, at, repeats));
    }
    m.evaluate = median(ours.wall);
    row("evaluate", m, "scalar -O2", ours, theirs, std::nullopt);
  }

 private:
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

  // Times of step(i) for every i of a block.
  template <class Step>
  static void time_block(int block, BenchTimes& times, const Step& step) {
    for (int i = block * per_block; i < (block + 1) * per_block; ++i) {
      const BenchTime start = bench_time();
      step(static_cast<std::size_t>(i));
      times.add(bench_time() - start);
    }
  }

  void row(const std::string& what, const Measured& m, const char* baseline, const BenchTimes& ours,
           const BenchTimes& theirs, std::optional<std::size_t> k, double by_refit = unknown) {
    rows_.push_back({.name = what + " " + m.method,
                     .baseline = baseline,
                     .ours = median(ours.wall),
                     .theirs = theirs.median(),
                     .error = m.inside,
                     .n = m.n,
                     .k = k,
                     .by_refit = by_refit});
  }

  const Globals& globals_;
  const Case& case_;
  const std::vector<Sample>& pool_;
  std::vector<Comparison>& rows_;
};

}  // namespace

void time_model(const Globals& globals, const Case& taken, const std::vector<Sample>& pool,
                const ModelOptions& options, Measured& m, std::vector<Comparison>& rows) {
  ModelTiming timing(globals, taken, pool, rows);
  timing.time_fits(options, m);
  timing.time_evaluation(options, m);
}

}  // namespace forefeel::bench
