#pragma once
// The field of measured forces: a Gaussian process (gaussian_process.hpp) of all rows, or of the rows nearest to a
// place. Where there are many rows, the mean of a box of neighbouring rows stands for them: its noise is less by the
// square root of their number, and lines that are dense along themselves weigh no more than their length. Boxes are
// made only where the field bends less within a box than the noise of its mean; else the rows nearest to a place serve,
// thinned where they lie on lines or in heaps, so that they are of several of these.
//
// The likeliest law of a smooth field may be much longer than the extent of the rows: the field is then a polynomial of
// low degree, and the process is sure of it between the rows, where nothing was measured. So the deviation comes from a
// second law, `doubt`, the likeliest of those no longer than the extent, with lengths that differ by direction
// (stretch.hpp):
//   s^2 = 3 v_doubt(x) + |f~_doubt(x) - f~(x)|^2
//
// A process is as good as its law. Where it is unsure, as between two presses far apart, a thin plate spline of the
// rows (thin_plate.hpp) is often nearer. So the force is the mean of both with weights 1 / v^2; the deviation of the
// spline counts as 0.7 of what it is, for it is seldom far off. Where the process knows the field, it has nearly all
// weight. Where the likeliest law is a rough one (Matern's), the field may have a kink between the rows as it has one
// elsewhere: s is then at least the deviation of the spline.
//
// Directions that the rows do not know. Rows of a line, a curve or a surface determine nothing across it. Let M be the
// covariance of the positions within 4 d of x (d: distance of the nearest row; at least 12 rows) and c their mean. An
// eigenvector u of M is unknown at x if |u.(x - c)| exceeds four times the deviation of the rows along u. A direction
// is thin if the rows deviate in it by less than a fifth of their largest deviation. There the rows bend, as those of a
// curve do, so c and the deviation are those of a parabola along the rows. Then
//   foot     x without its components along unknown directions, about c: the place on the line that is nearest to x
//   across   E = |x - foot| [m]; unless S is stated, S E is at most twice the largest force known
// The components of x in thin directions beyond 1.5 deviations (a line with noise in its positions) count in E, but do
// not move the foot. At the foot's force the error is at least S E. S [N/m]: the largest secant
// |F_i - F_j| / |x_i - x_j| of neighbouring boxes, or the largest force over half the extent of the rows, if that is
// more.
//
// Rows within l may lie beyond x, or on the far side of the foot, within 60 degrees of the direction across and at
// least E away: those of the next line of a raster, or of another turn of a curve. Then x itself is used in place of
// the foot, and its error is at least the lesser of S E and the deviation halfway to the nearest of these rows.

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
  Processes processes_of(const MeasuredRows& rows) const;
  MeasuredRows rows_about(const Vec3& x) const;
  Prediction predicted(const Vec3& x) const;
  Vec3 bounded(const Vec3& force) const;

  const StateSpace* known_;
  FieldOptions options_;
  double most_ = 0;         // largest force [N]
  std::vector<Vec3> rows_;  // positions
  Processes all_;           // none: of each place
};

}  // namespace forefeel
