#pragma once
// Keeps a model f~ (model.hpp) up to date while the state space grows and the HIP moves. Each update chooses
// the neighbour set (neighbours.hpp, jet_set.hpp) and replaces k of n centres in O(k n^2), or refits if that is faster
// (rbf_fit.hpp). With jets, a HIP outside the radius of every jet gets the RBF model of force and stiffness if 8 states
// are known: past a fold or in creases a jet says nothing, and its neighbours' data do.

#include "approx/model/model.hpp"

namespace forefeel {

// Marks that the caller of update() sets on the new model.
struct UpdateTag {
  std::uint64_t serial = 0;  // serial number of the model; 0: the updater numbers its models itself
  bool guess = false;        // the space holds a guess: states() of the model is empty
};

class ModelUpdater {
 public:
  // The space must outlive the updater; both belong to one thread.
  ModelUpdater(const StateSpace& space, ModelOptions options);
  ~ModelUpdater();
  ModelUpdater(ModelUpdater&&) noexcept;

  // Replaces `out` by the model for a HIP at `hip`. False while no state is known; `out` is then the zero
  // model.
  bool update(const Vec3& hip, Model& out, UpdateReport* report = nullptr, const UpdateTag& tag = {});
  Model model_at(const Vec3& hip);
  // Forgets earlier positions: the next model depends only on the space and the HIP position.
  void forget();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A model from all given states at once, without neighbour selection: for offline evaluation and tests.
Model fit_model(std::span<const State> states, const ModelOptions& options, const Vec3& centre);

}  // namespace forefeel
