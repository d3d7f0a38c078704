#pragma once
// Forces of known states, of measured ones too, at places anywhere, as evaluation makes them.

#include <memory>
#include <optional>

#include "approx/measured/force_field.hpp"
#include "approx/model/force_makers.hpp"

namespace forefeel {

// What gives the force at a place: a Gaussian process of measured forces, or else an RBF model.
struct PlaceMethod {
  ModelOptions model = {};
  bool all = false;                        // one model of all states
  std::optional<FieldOptions> field = {};  // the process (measured/force_field.hpp)
  std::optional<FieldOptions> judge = {};  // of the error and of the directions that the states do not know
};

// Forces of some known states at one place after the other. Where `judge` says that the states do not know a direction
// across them, the force is that of the foot.
class PlaceForces {
 public:
  PlaceForces(const StateSpace& known, const PlaceMethod& method);  // the space must outlive this
  struct Found {
    Vec3 force = Vec3::Zero();                          // [N]
    std::optional<ForceField::Prediction> judged = {};  // none without a judge
  };
  Found at(const Vec3& x);

 private:
  std::unique_ptr<ForceMaker> models_;  // null: a process
  std::optional<ForceField> field_, judge_;
};

}  // namespace forefeel
