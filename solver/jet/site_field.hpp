#pragma once
// The energy of a body that is pressed at any place of its surface: a model of E(s, x) from jets at rest at sites s_i,
//   E(s, x) = 1/2 x^T K(s) x + c(s)^2 sum_i w_i(s) N_i(s, Q_i B x),   B = K(s)^(1/2) / c(s)      [J]
//   f = -dE/dx,   dE/ds, by the exact derivatives of all its parts
// s site [m], x displacement of the tip [m], both in the axes of the mesh; K(s) [N/m] the exact stiffness at rest of
// the body under the pad (rest_sites.hpp); c = det(K)^(theta/6); Q_i the least turn that takes the normal n(s) to
// n(s_i). N_i holds the degrees 3 to 5 of the jet of site i in the variables z = B_i x, so that with weights 1, 0, 0, …
// E is E_i(A Q x) with A K_i A = Q K Q^T but for the order of square roots. Its coefficients are not constant: they
// follow the neighbours' by least squares, to second degree in the place of s in the plane across n(s_i) (Renka 1988,
// Multivariate interpolation of large sets of scattered data). The weights are
//   w_i ~ (1 - q)^3 / (q + 0.01)^2,   q = delta_i^2 / reach^2 < 1,   delta of site_cover.hpp,
// cut off smoothly where the way along the surface is much longer. All is continuously differentiable in s on a facet
// and continuous over edges; E is a potential, K symmetric. A linear body is exact: its jets vanish.
//
// theta = 1 keeps the displacement at which a site's nonlinearity is felt, theta = 0 the energy.

#include <functional>
#include <memory>
#include <stop_token>
#include <vector>

#include "solver/jet/jet_polynomial.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

using JetSlopes = Eigen::Matrix<double, static_cast<int>(jet_size), 5>;

struct SiteFieldOptions {
  double spacing = 0.010;  // every place has a site within this delta [m]
  int threads = 1;
  double theta = 1;
  int degree = 2;             // of the coefficients over the surface: 0, 1 or 2
  double reach = 1.6;         // of the weights, over the spacing
  double fitted = 2.6;        // distance of the neighbours that coefficients follow, over the spacing
  Vec3 first = Vec3::Zero();  // the sites begin at the place nearest to this
};

// E and its derivatives at (s, x).
struct SiteTerms {
  double energy = 0;              // [J]
  Vec3 force = Vec3::Zero();      // -dE/dx [N]
  Mat3 stiffness = Mat3::Zero();  // d2E/dx2 [N/m]
  Vec3 by_site = Vec3::Zero();    // dE/ds [N]; only its part in the facet's plane has a meaning
};

// The field at one site, ready for any x. Copies; valid for ever.
class SiteModel {
 public:
  // degree: of E that is counted, 2 to 5. slopes must have been asked for, for by_site.
  SiteTerms at(const Vec3& x, int degree = 5) const;
  // Of the force's error at x, from the last two degrees of the jets [N].
  double estimate(const Vec3& x) const;
  // How far the neighbours' own forces are from their mean, root mean square by weight [N]; 0 after take().
  double spread(const Vec3& x) const;
  // E = 1/2 x^T K x + the sum of these coefficients and the monomials of x; K is that of rest().
  JetCoefficients polynomial() const;
  const SiteRest& rest() const { return rest_; }
  const Mat3& root() const { return root_; }                       // B
  const std::array<Mat3, 3>& root_by() const { return root_by_; }  // by the coordinates of s
  double scale() const { return scale_; }                          // c^2
  const Vec3& scale_by() const { return scale_by_; }
  bool has_slopes() const { return slopes_; }
  const SurfaceMap::OnFacet& where() const { return where_; }  // the place
  std::size_t neighbours() const { return parts_.size(); }

  // In place of neighbours: degrees 3 to 5 as one polynomial in x, with its derivatives by s, at a place of which
  // `rest` is known with slopes. root: also B and c^2. Allocates nothing.
  void take(const SurfaceMap::OnFacet& where, const SiteRest& rest, const JetCoefficients& polynomial,
            const JetGradient& polynomial_by, bool root, double theta);

 private:
  friend class SiteField;
  struct Part {
    double weight = 0;
    Vec3 weight_by = Vec3::Zero();
    JetCoefficients coefficients = JetCoefficients::Zero();
    JetGradient coefficients_by = JetGradient::Zero();
    Mat3 turn = Mat3::Zero();
    std::array<Mat3, 3> turn_by{Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
  };
  void set_root(double theta);

  SurfaceMap::OnFacet where_;
  SiteRest rest_;
  Mat3 root_ = Mat3::Zero();  // B
  std::array<Mat3, 3> root_by_{Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
  double scale_ = 1;  // c^2
  Vec3 scale_by_ = Vec3::Zero();
  std::vector<Part> parts_;
  bool slopes_ = false, is_whole_ = false;  // is_whole_: as one polynomial
  JetCoefficients whole_ = JetCoefficients::Zero();
  JetGradient whole_by_ = JetGradient::Zero();
};

// What solves give for one site of a field.
struct FieldSite {
  SurfacePlace place;
  Vec3 normal = Vec3::Zero();                     // mean normal under the pad
  Mat3 stiffness = Mat3::Zero();                  // K_i [N/m]
  JetCoefficients own = JetCoefficients::Zero();  // N_i at s_i
};

class SiteField {
 public:
  // Makes the field; `progress` (0 to 1, first with what `kept` has) is called by one thread at a time. Stops early,
  // with fewer sites, if asked.
  SiteField(std::shared_ptr<const RestSites> sites, const SiteFieldOptions& options,
            const std::function<void(double)>& progress = {}, const std::stop_token& stop = {},
            KeptPieces* kept = nullptr);

  // The same field again, from sites() of one with these options: nothing is solved.
  SiteField(std::shared_ptr<const RestSites> sites, const SiteFieldOptions& options,
            const std::vector<FieldSite>& known);

  SiteModel at(const SurfacePlace& site, bool slopes) const;  // any thread
  std::vector<FieldSite> sites() const { return {sites_.begin(), sites_.end()}; }
  EnergyJet jet_of(const FieldSite& site) const;  // the jet at rest of one of them, of order 4
  std::size_t size() const { return sites_.size(); }
  const RestSites& rest() const { return *rest_; }
  const std::shared_ptr<const RestSites>& rest_shared() const { return rest_; }
  const SiteFieldOptions& options() const { return options_; }
  const SurfacePlace& place(std::size_t i) const { return sites_[i].place; }
  const Mat3& stiffness(std::size_t i) const { return sites_[i].stiffness; }

 private:
  struct Site : FieldSite {
    Mat3 axes = Mat3::Identity();          // rows: two directions across the normal, and the normal
    JetSlopes slopes = JetSlopes::Zero();  // by p, q, p^2, p q, q^2 of the place over spacing
  };
  struct Near {
    std::int32_t site = 0;
    double way = 0;  // along the surface [m]
  };
  void make_jets(const std::function<void(double)>& progress, const std::stop_token& stop, KeptPieces* kept);
  void make_jet(SiteJets& jets, Site& site) const;
  void connect();
  void find_near();
  void follow_neighbours(std::size_t i);
  double squared_delta(const Site& site, const Vec3& at, const Vec3& normal) const;
  void add_parts(const SurfacePlace& place, const SiteRest& rest, SiteModel& model) const;

  std::shared_ptr<const RestSites> rest_;
  SiteFieldOptions options_;
  std::vector<Site> sites_;
  std::vector<std::vector<Near>> near_;  // of each node of the surface, ascending
  double length_ = 0;                    // L of delta [m]
  double longest_way_ = 0;               // along the surface, of a neighbour [m]
};

}  // namespace forefeel
