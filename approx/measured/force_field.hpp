#pragma once
// The field of measured forces, for states without stiffness: noisy, and often on lines, levels or presses. A Gaussian
// process of all rows, or of the rows nearest to a place, blended with a thin plate spline of them. Use it in place of
// a model through single rows, which takes their noise for slope, and to judge any other model of such states:
//
//   const std::optional<FieldOptions> law = field_of(states);   // field_law.hpp
//   const ForceField field(space, *law);
//   const ForceField::Prediction made = field.at(x);
//   made.force;  made.deviation;  made.least_error;             // [N]
//
// With f~, v of the likeliest law and f~_d, v_d of a second law that is no longer than the extent of the rows
// (gaussian_process.hpp), and f~_s, v_s of the spline (thin_plate.hpp):
//   f(x) = (f~ / v^2 + f~_s / v_s^2) / (1 / v^2 + 1 / v_s^2)
//   s(x)^2 = 3 v_d + |f~_d - f|^2
// Rows of a line, a curve or a surface determine nothing across it. There f is that of the foot, the place among the
// rows nearest to x, and its error at least S E: E = |x - foot| [m], S the largest stiffness between rows [N/m].

#include <cmath>
#include <memory>
#include <optional>
#include <span>

#include "approx/measured/field_law.hpp"
#include "approx/measured/thin_plate.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

class ForceField {
 public:
  struct Prediction {
    Vec3 force = Vec3::Zero();  // [N]
    Vec3 alone = Vec3::Zero();  // of the process without the spline [N]
    double deviation = 0;       // of |force - f~| at the foot, without noise: s [N]
    double own_deviation = 0;   // by the likeliest law alone, to tell places that are alike: sqrt(3 v) [N]
    Vec3 foot = Vec3::Zero();   // x itself where all directions are known [m]
    double least_error = 0;     // S E [N]
    // s of a model with this force: the deviation, and how far the model is from it [N].
    double scale_of(const Vec3& model) const { return std::hypot(deviation, (force - model).norm()); }
  };
  // The space must outlive this. At least one state.
  ForceField(const StateSpace& known, const FieldOptions& options);
  Prediction at(const Vec3& x) const;
  // Force at x, and K = -df/dx by central differences over `step` [m], all of the rows about x: where these change
  // between two places, the force steps, and that is no stiffness. Costs two processes, as at() does three.
  struct Linear {
    Vec3 force = Vec3::Zero();      // [N]
    Mat3 stiffness = Mat3::Zero();  // [N/m]
  };
  Linear linear(const Vec3& x, double step) const;
  double bound() const;  // no force is larger: twice the largest known one [N]

 private:
  struct Foot {
    Vec3 at = Vec3::Zero();
    double across = 0;                 // E [m]
    std::optional<Vec3> between = {};  // halfway to the nearest row that tells of the direction across
  };
  Foot foot_of(const Vec3& x) const;
  std::optional<Vec3> row_across(const Vec3& x, const Vec3& foot) const;
  // The processes of some rows.
  struct Processes {
    std::shared_ptr<const GaussianProcess> own,
        doubt;                                // no doubt: the law of the deviation is that of the force
    std::shared_ptr<const ThinPlate> spline;  // null: none
  };
  enum class With { doubt, force_alone };
  Processes processes_of(const MeasuredRows& rows, With with) const;
  MeasuredRows rows_about(const Vec3& x) const;
  Prediction predicted(const Vec3& x) const;
  // The blend of the likeliest law and the spline, and what both give.
  struct Blend {
    Vec3 force = Vec3::Zero();
    GaussianProcess::Prediction likeliest = {}, plain = {};
  };
  static Blend blend(const Processes& of, const Vec3& x);
  Vec3 bounded(const Vec3& force) const;

  const StateSpace* known_;
  std::shared_ptr<const StateSpace> even_;  // without most rows of heaps; null: there are none
  FieldOptions options_;
  double most_ = 0;  // largest force [N]
  Processes all_;    // none: of each place
};

}  // namespace forefeel
