#pragma once
// Makes the models of a session from the states known so far:
//   rbf                    radial basis functions on a neighbour set that follows the HIP
//                          (approx/select/updater.hpp). With stiffness the first three states reach twice as
//                          far as states of the lattice do.
//   trilinear, tricubic    interpolation in the lattice cell around the HIP, as before RBF models
//                          (approx/model/lattice_field.hpp). Where a corner of the cell is not known: the
//                          force of the nearest state.
// While no state is known it makes the tangent of the first guess, if there is one.

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
