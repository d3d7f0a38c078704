#pragma once
// What makes the models of a session from the states known so far:
//   rbf                    the RBF model whose neighbour set follows the HIP (approx/select/updater.hpp); with stiffness the
//                          first three states reach twice as far as states of the lattice do
//   trilinear, tricubic    interpolation in the lattice cell around the HIP (approx/predecessors/methods.hpp), as before RBF models:
//                          where a corner of the cell is not known, the force of the nearest state

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "approx/select/updater.hpp"
#include "scheduling/render/session_model_options.hpp"

namespace forefeel {

class SessionModel {
 public:
  // The space must outlive it; both belong to one thread.
  SessionModel(const StateSpace& space, const ModelRecipe& recipe);

  // As ModelUpdater: false while no state is known and there is no first guess either. That has no states.
  bool update(const Vec3& hip, Model& out, UpdateReport* report = nullptr);
  Model model_at(const Vec3& hip);
  void forget();

 private:
  bool update_guess(const Vec3& hip, Model& out, UpdateReport* report);
  bool update_lattice(const Vec3& hip, Model& out, UpdateReport* report);

  const StateSpace& space_;
  ModelUpdater rbf_, first_;
  std::unique_ptr<StateSpace> guessed_;  // rest with the first guess; null: none
  std::optional<ModelUpdater> guess_;
  bool with_stiffness_, lattice_, cubic_;
  std::vector<StateId> near_;
  std::vector<State> states_;
  ModelDraft draft_;
  std::uint64_t serial_ = 0;
};

}  // namespace forefeel
