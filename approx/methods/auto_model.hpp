#pragma once
// Chooses a model for a set of states and estimates its error. Some known forces f are held out (left_out.hpp).
// Held-out positions are as far from known states as the wanted places. The remaining states predict the held-out
// forces (f~) with the same models that will be used later (ModelUpdater). The candidate with the least root mean
// square of |f - f~| [N] is chosen. The expected error is the error at the held-out positions. f is the force as
// measured, so its noise is part of the error.
//
// Measured states have further candidates: a Gaussian process of all states, with a thin plate spline beside it and
// without; and, of 480 states or more, one of the 120 nearest states whose law is sought anew at each place
// (measured/field_law.hpp). That one is chosen if the law of all states is the roughest, or if it predicts what is left
// out with less
//   3/2 log mean(|e|^2 / (3 v)) + 3/2 mean(log v),   v: variance of the error e, with noise
// or with errors less by a fifth. Else another model replaces the process only if its errors are surely less, and by a
// tenth. Candidates are otherwise: kernels r, r^3, r^5; the nearest 25 to 200 states, 25 or 50 states by label, or one
// model of all states (at most 1000 rows); ridges (nuggets) from 0 to 0.1. A ridge is used only if it reduces the error
// by 2 %. All candidates are tried on some of the positions, the best ones on all.

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "approx/model/model_options.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct SeenPlace;

// What a caller fixes of a model; the rest is left open.
struct ModelWishes {
  std::optional<Kernel> kernel = {};
  std::optional<Data> data = {};
  std::optional<std::size_t> neighbours = {};
  std::optional<Select> select = {};
  std::optional<double> ridge = {};
};
// What is open: quintic on force+stiffness if the states have stiffness, else cubic on force; 25 neighbours with
// stiffness, else 100, but 1 to `states`; rule label; no ridge.
ModelOptions wished_model(const ModelWishes& wishes, bool stiffness, std::size_t states);

struct AutoModelOptions {
  std::optional<FieldOptions> field =
      {};  // of measured states: a candidate, and the judge of unknown directions

  ModelWishes model = {};  // the rest is chosen; data: force+stiffness where the states have it
  double spacing = 0.006;  // h of the state space [m]
  std::function<void(double)> progress = {};  // called by one thread with the share done
};

struct AutoModel {
  ModelOptions model = {};
  bool all = false;  // one model of all states is used for every place (fit_model() about their middle)
  std::optional<FieldOptions> field =
      {};  // a Gaussian process in place of the model (measured/force_field.hpp)
  // Quantiles of |f - f~| at the held-out positions [N]; NaN if there are too few states to choose.
  double p50 = unknown, p95 = unknown;
  std::size_t positions = 0, groups = 0;  // left out
  std::size_t beyond =
      0;                // wanted places farther from the states than any position left out inside, or outside
  bool alike = true;    // what was left out is no nearer to the rest than the wanted places to the states
  bool across = false;  // p95 is that of places across the states, where nothing was left out
};

// states: usable ones, one at each position. wanted: where the force is wanted, as seen from the states (left_out.hpp);
// empty: not known. With fewer than 8 states or 3 groups the defaults are returned.
AutoModel choose_model(std::span<const State> states, const AutoModelOptions& options,
                       std::span<const SeenPlace> wanted);

}  // namespace forefeel
