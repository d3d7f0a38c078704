#pragma once
// The force at a place, whatever it comes from, and what makes it from the known states. Kinds of models:
//   Model           radial basis functions, energy jets, a lattice cell (model.hpp)
//   Approximation   an older method (methods/older_methods.hpp)

#include <cstddef>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// Where the tip is: its position, or with a site of the surface the displacement there.
struct Place {
  Vec3 x = Vec3::Zero();   // [m]
  SurfacePlace site = {};  // none: one place of contact for ever
};

// Limits of a model. Its force never exceeds `bound` [N]. Farther than `tangent` [m] outside the hull of its states,
// the model is replaced by its tangent. `held` [m]: distance from the point of the tangent beyond which the force is
// held constant. NaN: the model has no such limit.
struct Reach {
  double bound = unknown, tangent = unknown, held = unknown;
};

struct Answer {
  Vec3 force = Vec3::Zero();  // [N]
  double error = unknown;     // own estimate, trust included [N]; NaN: none
  bool trusted = false;       // the estimate, within its validity, is within the model's tolerance
  Reach reach = {};
  std::string_view kernel{};  // after step-down; empty: none
};

// Never changes in part, and any thread may ask. A Model allocates nothing and locks nothing when asked.
class ForceModel {
 public:
  virtual ~ForceModel() = default;
  virtual Answer at(const Place& place) const noexcept = 0;
  virtual Vec3 force(const Place& place) const noexcept {
    return at(place).force;
  }  // alone, where that is cheaper

 protected:
  ForceModel() = default;
  ForceModel(const ForceModel&) = default;
  ForceModel& operator=(const ForceModel&) = default;
};

struct UpdateReport {
  std::size_t n = 0;         // states in the model
  std::size_t replaced = 0;  // k
  bool refit = false;
  Label label = Label::blank;  // of the HIP; it decides how the set is chosen
};

// The models of some known states at one place after the other, of a kind that is chosen once.
class ForceMaker {
 public:
  virtual ~ForceMaker() = default;
  // The model that serves this place, the same whatever was asked before; valid until the next call.
  virtual const ForceModel& at(const Place& place, UpdateReport* report = nullptr) = 0;
};

// What models give at many points.
struct EvaluatedPoints {
  std::vector<Vec3> forces;                 // [N]
  std::vector<Label> labels;                // coverage
  std::vector<Reach> reach;                 // (force_model.hpp) of the older methods the bound alone
  std::vector<double> fit_us, evaluate_ns;  // of points whose model was made or changed; of some points
  std::size_t fitted = 0, updated = 0,
              reused = 0;                 // number of points whose model was made anew, updated, kept
  std::vector<std::string_view> kernels;  // by point, after step-down; none for the older methods
  std::vector<char> trusted;              // by point (Model::at); none if no model is of jets
  std::size_t stepped_down = 0;
};

}  // namespace forefeel
