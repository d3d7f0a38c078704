#pragma once
// Keeps a model up to date with a growing state space and a moving HIP: chooses the neighbour set and
// replaces k of n centres in O(k n^2) where that is cheaper than a refit.

#include "approx/model/model.hpp"

namespace forefeel {

struct UpdateReport {
  std::size_t n = 0;         // states in the model
  std::size_t replaced = 0;  // k
  bool refit = false;
  Label label = Label::blank;  // that chose the set
};

class ModelUpdater {
 public:
  // The space must outlive the updater; both belong to one thread.
  ModelUpdater(const StateSpace& space, ModelOptions options);
  ~ModelUpdater();
  ModelUpdater(ModelUpdater&&) noexcept;

  // Writes the model for a HIP at `hip` into `out`. False (and `out` is the zero model) while no state is
  // known.
  bool update(const Vec3& hip, Model& out, UpdateReport* report = nullptr);
  Model model_at(const Vec3& hip);
  // From here on as if newly made: the next model depends on the space and the HIP alone, not on where the
  // HIP was.
  void forget();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A model from all given states at once, without neighbour selection: for offline evaluation and tests.
Model fit(std::span<const State> states, const ModelOptions& options, const Vec3& centre);

}  // namespace forefeel
