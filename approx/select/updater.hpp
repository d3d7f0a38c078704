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

// How an update is to be numbered, and whether its states are to be named.
struct UpdateTag {
  std::uint64_t serial = 0;  // 0: the updater counts
  bool guess = false;        // the space holds a guess: states() of the model is empty
};

class ModelUpdater {
 public:
  // The space must outlive the updater; both belong to one thread.
  ModelUpdater(const StateSpace& space, ModelOptions options);
  ~ModelUpdater();
  ModelUpdater(ModelUpdater&&) noexcept;

  // Replaces `out` by the model for a HIP at `hip`. False while no state is known; `out` is then the zero model.
  bool update(const Vec3& hip, Model& out, UpdateReport* report = nullptr, const UpdateTag& tag = {});
  Model model_at(const Vec3& hip);
  // From here on as if newly made: the next model depends on the space and the HIP alone, not on where the
  // HIP was.
  void forget();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A model from all given states at once, without neighbour selection: for offline evaluation and tests.
Model fit_model(std::span<const State> states, const ModelOptions& options, const Vec3& centre);

}  // namespace forefeel
