#pragma once
// Jets at rest of single places and solved states as corrections of a field of jets at rest (site_field.hpp):
//   E(s, x) = E_field(s, x) + sum_j r_j R_j / (r_0 + sum_j r_j) + sum_k p_k C_k / (p_0 + sum_k p_k)
//   R_j = c(s)^2 / c_j^2 (the jet's degrees 2 to 5 minus the field's at s_j)(y)
//   C_k = c(s)^2 / c_k^2 (|y| / |x_k|)^6 P_k(y - x_k),   y = B_k^-1 Q_k B(s) x
// over jets j made at s_j and states k at (s_k, x_k), with B, c^2 and the least turn Q of site_field.hpp, so y = x at
// s_k. P_k is the Taylor polynomial in d of (E_k(x_k + d) - E_before(s_k, x_k + d)) |x_k|^6 / |x_k + d|^6, to the
// degree that the state has: 2 by force and stiffness, 3 to 5 by its jet; E_before is the field's with the jets R. A
// jet at s_k itself takes the field's error between its sites out of P_k, so what is left is the jets' truncation. It
// begins with degree 6: therefore a correction carries on to other depths in the same direction, and near rest the
// field stands. The weights
//   r_j = (1 - q)^3 / q^2, q = delta_j^2 / reach_r^2;   p_k the same, q = delta_k^2 / reach_s^2 + |y - x_k|^2 /
//   reach_k^2
// for q < 1 (delta of site_cover.hpp) are cut off smoothly where the way along the surface is much longer. reach_k is
// 0.8 |x_k|, or where the state's series ends before, divided by the root of the state's surprise: where a fold lies
// between rest and x_k, the law of growth does not hold. With 200 states on the way of a hand that pressed a St.
// Venant-Kirchhoff liver to 16 mm, four runs, the p95 of the force's error was 6 to 15 % without this, and is 0.6 to
// 10 % with it. At s_j, E is
// the jet's. At a state whose site has a jet, E is the state's own to second order. r_0 and p_0, constants, are the
// field's: E is continuous where the last neighbour ends. E stays a potential. The field's own K is exact, so a linear
// body has no corrections; over patches (field_patches.hpp), whose K is near the exact one, jets at rest bring the
// difference.
//
// A loop asks several times a frame. So each facet has a list of the states that reach it, and their polynomials are
// kept in z = Q_k B(s) x, to be summed several at a time (solver/kernels/site_sums.hpp).

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/jet/jet_polynomial.hpp"
#include "solver/jet/site_cover.hpp"
#include "solver/jet/site_field.hpp"

namespace forefeel {

// Polynomials in three variables to degree 5,
//   p(d) = sum_{a + b + c <= 5} p_abc d_x^a d_y^b d_z^c,
// by ascending degree, within one by descending a, then b: degrees 3 to 5 are in the order of an EnergyJet.

inline constexpr int series_size = 10 + static_cast<int>(jet_size);
using Series = Eigen::Matrix<double, series_size, 1>;

// 1/2 d^T K d - f . d + e and a jet's terms.
Series series_of(double e, const Vec3& f, const Mat3& k, const JetCoefficients& jet);
Series product(const Series& p, const Series& q);  // to degree 5
Series moved(const Series& p, const Vec3& x);      // p(x + d) as a polynomial in d
Series turned(const Series& p, const Mat3& t);     // p(T d)
Series inverse_growth(const Vec3& x);              // (|x| / |x + d|)^6
Series cut_after(const Series& p, int degree);     // the degrees above are zero
Mat3 stiffness_of(const Series& p);                // its second derivatives at 0

class FieldPatches;
struct SiteSums;

struct DeepOptions {
  double site_reach = 1;    // reach_s over the pad's radius
  double reach = 0.8;       // reach_k over |x_k|, or less where the state's series ends before
  double field_weight = 2;  // p_0
  double rest_reach = 1;    // reach_r over the field's spacing
  double rest_weight = 1;   // r_0
};

// Immutable; any thread may ask, and nothing is allocated by a question.
class DeepStates {
 public:
  // No states yet. patches: models of at() are theirs, where they have the facet; null: the field's.
  explicit DeepStates(std::shared_ptr<const SiteField> field, const DeepOptions& options = {},
                      std::shared_ptr<const FieldPatches> patches = {});
  // The field's or the patches' at a place, with what corrections need.
  SiteModel model(const SurfacePlace& place) const;
  // Those of this and of the list that can serve: solved, with a site on the surface that is not clamped, energy and
  // stiffness; those at x = 0 by their jets, of which the list's come before its states, and those of the field's
  // sites are left out. Numbers go on from size().
  // Takes about 0.5 ms a new state, and 0.1 us a known one.
  std::shared_ptr<const DeepStates> with(std::span<const State> states) const;

  std::size_t size() const { return records_.size(); }
  const SurfacePlace& place(std::size_t k) const;
  const Vec3& displacement(std::size_t k) const;  // x_k
  // |f_k - f_before| over what the field estimated there; 0 of a jet at rest.
  double surprise(std::size_t k) const;
  // Over patches, of each state the error of the set that it was added to, over the estimate there.
  const std::vector<double>& scores() const { return scores_; }
  const SiteField& field() const { return *field_; }

  // model: of this place, by model() or the field's. stiff: with the stiffness; else the corrections' part of it is
  // left out.
  SiteTerms at(const SiteModel& model, const SurfacePlace& place, const Vec3& x, bool stiff = true) const;
  // Of the force's error [N]. The root of the sum of squares of: the spread of the states' corrections about their
  // mean, the field's own correction, 0, among them; the field's estimate times its weight and the usual surprise();
  // and, the less the nearer a jet at rest is, what the field's neighbours differ by, and over patches their error()
  // times |K x|.
  double estimated_error(const SiteModel& model, const SurfacePlace& place, const Vec3& x) const;
  // Three times the estimate is within tolerance * max(|f|, floor).
  bool trusted(const SiteModel& model, const SurfacePlace& place, const Vec3& x, double tolerance,
               double floor) const;

 private:
  struct Record;
  struct Pack;
  std::shared_ptr<const Record> record_of(const State& state) const;
  bool add(const State& state);
  double score(const State& state) const;
  // Puts a state first in a facet's list. way: over the surface to the facet's corners [m].
  static void list(const Record& record, const Vec3& way, std::shared_ptr<const Pack>& first);
  struct Rest {  // degrees 2 to 5 at a place, for any x
    Mat3 stiffness = Mat3::Zero();
    JetCoefficients coefficients = JetCoefficients::Zero();
  };
  Rest before(const SiteModel& model, const SurfacePlace& place) const;
  std::array<SiteSums, 2> sums(const SiteModel& model, const SurfacePlace& place, const Vec3& x,
                               bool bend) const;

  std::shared_ptr<const SiteField> field_;
  std::shared_ptr<const FieldPatches> patches_;
  DeepOptions options_;
  std::shared_ptr<const EdgeDistances> ways_;
  double reach_ = 0, rest_reach_ = 0, length_ = 0;  // reach_s, reach_r and L of delta [m]
  double far_ = 0;                                  // along the surface, from where on a state fades [m]
  double usual_surprise_ = 1;
  std::vector<double> scores_;
  std::vector<std::shared_ptr<const Record>> records_;
  // Of each facet what reaches it: of 2 f the jets at rest, of 2 f + 1 the states; null: none.
  std::vector<std::shared_ptr<const Pack>> near_;
};

}  // namespace forefeel
