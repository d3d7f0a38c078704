#pragma once
// Makes the models of a session from the states known so far, by one of three methods:
//   rbf                    radial basis functions on a neighbour set that follows the HIP (approx/model/updater.hpp).
//                          With stiffness, models of at most three states assume a spacing of 2 h, because the first
//                          states lie farther apart than the lattice.
//   trilinear, tricubic    interpolation in the lattice cell around the HIP, the older method
//                          (approx/model/lattice_field.hpp). If a corner of the cell is unknown, the force is that at
//                          the nearest point of a complete cell, or that of the nearest state if this is nearer.
// While no state is known, the model is the linear force of the first guess, if there is one.

#include <memory>
#include <utility>
#include <vector>

#include "approx/model/updater.hpp"
#include "scheduling/render/session_model_options.hpp"

namespace forefeel {

class SessionModel {
 public:
  // The space must outlive this object; both belong to one thread.
  SessionModel(const StateSpace& space, const ModelRecipe& recipe);

  // As ModelUpdater::update(). Returns false while there is neither a known state nor a first guess. The
  // model of a first guess has no states.
  bool update(const Vec3& hip, Model& out, UpdateReport* report = nullptr);
  Model model_at(const Vec3& hip);
  void forget();

 private:
  bool update_guess(const Vec3& hip, Model& out, UpdateReport* report);
  bool update_lattice(const Vec3& hip, Model& out, UpdateReport* report);

  struct Guess {
    Guess(StateSpace of_guess, const ModelOptions& tangent)
        : space(std::move(of_guess)), updater(space, tangent) {}
    StateSpace space;  // rest with the first guess
    ModelUpdater updater;
  };
  struct Near {  // states of a lattice model
    std::vector<StateId> ids;
    std::vector<State> states;
  };
  const StateSpace& space_;
  ModelUpdater rbf_, first_;
  std::unique_ptr<Guess> guess_;  // null: none
  bool with_stiffness_;
  SessionMethod method_;
  Near near_;
  ModelDraft draft_;
  std::uint64_t serial_ = 0;
};

}  // namespace forefeel
