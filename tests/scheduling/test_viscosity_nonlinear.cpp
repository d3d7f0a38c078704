// How far the relaxation filter of the force is from a nonlinear viscoelastic body: a time-stepped finite-element solve
// whose second Piola-Kirchhoff stress relaxes in every element by one function,
//   S(t) = integral over s <= t of G(t - s) dS_e(s),   S_e = 2 dpsi / dC of the neo-Hookean law
// (finite linear viscoelasticity, Simo 1987), assembled here with linear tetrahedra and solved by Newton's method.
#include <Eigen/Dense>

#include "approx/switch/relaxation.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

const Viscosity branches{{0.3, 0.03}, {0.25, 0.4}};

class NonlinearMaxwell {
 public:
  explicit NonlinearMaxwell(const Body& body) : body_(body) {
    const double e = body.material.young, nu = body.material.poisson;
    mu_ = e / (2 * (1 + nu));
    lambda_ = e * nu / ((1 + nu) * (1 - 2 * nu));
    std::vector<char> held(body.mesh.nodes.size(), 0);
    for (const NodeIndex n : body.clamp) held[static_cast<std::size_t>(n)] = 1;
    for (const NodeIndex n : body.contact) held[static_cast<std::size_t>(n)] = 1;
    for (std::size_t n = 0; n < held.size(); ++n)
      for (int i = 0; i < 3 && !held[n]; ++i) free_.push_back(static_cast<int>(3 * n) + i);
    for (const Tet& tet : body.mesh.tets) {
      Element element{.tet = tet, .gradients = {}, .volume = 0, .elastic = Mat3::Zero(), .stress = {}};
      Mat3 edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = node(tet[static_cast<std::size_t>(k + 1)]) - node(tet[0]);
      element.volume = edges.determinant() / 6;
      element.gradients.block<3, 3>(0, 1) = edges.inverse().transpose();
      element.gradients.col(0) = -element.gradients.block<3, 3>(0, 1).rowwise().sum();
      element.stress.assign(branches.size(), Mat3::Zero());
      elements_.push_back(element);
    }
    u_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * body.mesh.nodes.size()));
  }

  // Moves the contact to x within `passed` [s]. Returns the force on the tip [N].
  Vec3 step(const Vec3& x, double passed) {
    for (const NodeIndex n : body_.contact) u_.segment<3>(3 * n) = x;
    Eigen::VectorXd force;
    for (int iteration = 0;; ++iteration) {
      Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(u_.size(), u_.size());
      force = Eigen::VectorXd::Zero(u_.size());
      for (const Element& element : elements_) add(element, passed, force, tangent);
      const Eigen::VectorXd rest = force(free_);
      if (rest.norm() < 1e-12 * (1 + force.norm())) break;
      REQUIRE(iteration < 30);
      u_(free_) -= Eigen::MatrixXd(tangent(free_, free_)).partialPivLu().solve(rest);
    }
    for (Element& element : elements_) keep(element, passed);
    Vec3 tip = Vec3::Zero();
    for (const NodeIndex n : body_.contact) tip -= force.segment<3>(3 * n);
    return tip;
  }

 private:
  struct Element {
    Tet tet;
    Eigen::Matrix<double, 3, 4> gradients;  // of the four shape functions [1/m]
    double volume;
    Mat3 elastic;              // S_e of the last step
    std::vector<Mat3> stress;  // by branch
  };

  Vec3 node(NodeIndex n) const { return body_.mesh.nodes[static_cast<std::size_t>(n)]; }

  Mat3 deformation(const Element& element) const {
    Mat3 f = Mat3::Identity();
    for (int i = 0; i < 4; ++i)
      f += u_.segment<3>(3 * element.tet[static_cast<std::size_t>(i)]) * element.gradients.col(i).transpose();
    return f;
  }

  Mat3 elastic(const Mat3& f) const {
    const Mat3 inverse = (f.transpose() * f).inverse();
    return mu_ * (Mat3::Identity() - inverse) + lambda_ * std::log(f.determinant()) * inverse;
  }

  // S of this step: `now` of S_e plus what the branches remember.
  static double now(double passed) {
    double share = long_term_share(branches);
    for (const MaxwellBranch& b : branches) share += b.share * weight(passed / b.time);
    return share;
  }
  static double weight(double a) { return a > 0 ? (1 - std::exp(-a)) / a : 1; }
  static Mat3 remembered(const Element& element, double passed) {
    Mat3 stress = Mat3::Zero();
    for (std::size_t b = 0; b < branches.size(); ++b) {
      const double a = passed / branches[b].time;
      stress += std::exp(-a) * element.stress[b] - branches[b].share * weight(a) * element.elastic;
    }
    return stress;
  }

  void keep(Element& element, double passed) const {
    const Mat3 next = elastic(deformation(element));
    for (std::size_t b = 0; b < branches.size(); ++b) {
      const double a = passed / branches[b].time;
      element.stress[b] =
          std::exp(-a) * element.stress[b] + branches[b].share * weight(a) * (next - element.elastic);
    }
    element.elastic = next;
  }

  void add(const Element& element, double passed, Eigen::VectorXd& force, Eigen::MatrixXd& tangent) const {
    const Mat3 f = deformation(element), inverse = (f.transpose() * f).inverse();
    const double c = now(passed), log_j = std::log(f.determinant());
    const Mat3 s = c * elastic(f) + remembered(element, passed);
    const Mat3 finv_t = f.inverse().transpose();
    for (int i = 0; i < 4; ++i) {
      const Vec3 gi = element.gradients.col(i), pi = finv_t * gi;
      force.segment<3>(3 * element.tet[static_cast<std::size_t>(i)]) += element.volume * (f * s * gi);
      for (int j = 0; j < 4; ++j) {
        // dS_e[dC] by F^-T g: lambda p_i p_j^T + (mu - lambda ln J) (p_j p_i^T + (g_i C^-1 g_j) I)
        const Vec3 gj = element.gradients.col(j), pj = finv_t * gj;
        const Mat3 block =
            gi.dot(s * gj) * Mat3::Identity() +
            c * (lambda_ * pi * pj.transpose() +
                 (mu_ - lambda_ * log_j) * (pj * pi.transpose() + gi.dot(inverse * gj) * Mat3::Identity()));
        tangent.block<3, 3>(3 * element.tet[static_cast<std::size_t>(i)],
                            3 * element.tet[static_cast<std::size_t>(j)]) += element.volume * block;
      }
    }
  }

  const Body& body_;
  double mu_ = 0, lambda_ = 0;
  std::vector<int> free_;
  std::vector<Element> elements_;
  Eigen::VectorXd u_;
};

struct Gap {
  double filter = 0, without = 0, most = 0;  // of the largest force [1], [1]; the largest force [N]
};

// Presses of this depth along an axis, in and out, with a hold between: at hand speed, 60 mm/s.
Gap gap_of(const Vec3& depth, int steps) {
  const auto body = test::small_body(Law::neo_hookean);
  NonlinearMaxwell truth(*body);
  ReferenceService elastic(reference_options(small_input(Law::neo_hookean)), 1);
  RelaxationFilter filter(branches);
  const double ramp = depth.norm() / 0.06;
  const auto share = [&](double t) {
    return t < ramp ? t / ramp : t < ramp + 0.1 ? 1 : std::max(0.0, (2 * ramp + 0.1 - t) / ramp);
  };
  Gap gap;
  double largest_gap = 0, largest_without = 0;
  const int frames = static_cast<int>((2 * ramp + 0.2) * 1000);
  for (int k = 0; k <= frames; ++k) {
    const Vec3 x = share(1e-3 * k) * depth;
    Vec3 exact = Vec3::Zero();
    if (k == 0) exact = truth.step(x, 0);
    for (int i = 1; i <= steps && k > 0; ++i)
      exact = truth.step(share(1e-3 * (k - 1 + double(i) / steps)) * depth, 1e-3 / steps);
    const Vec3 instant = elastic.get(x).force, filtered = filter.step(instant, 1e-3);
    gap.most = std::max(gap.most, exact.norm());
    largest_gap = std::max(largest_gap, (filtered - exact).norm());
    largest_without = std::max(largest_without, (instant - exact).norm());
  }
  gap.filter = largest_gap / gap.most;
  gap.without = largest_without / gap.most;
  return gap;
}

}  // namespace

TEST_CASE("viscous, nonlinear: at once and after a long hold the filter is exact, whatever the law") {
  // With one relaxation function S(t) = G(t) S_e keeps the shape, so that a held step is F(t) = G(t) F_e.
  const auto body = test::small_body(Law::neo_hookean);
  NonlinearMaxwell truth(*body);
  ReferenceService elastic(reference_options(small_input(Law::neo_hookean)), 1);
  RelaxationFilter filter(branches);
  const Vec3 x(0.004, 0.006, -0.01);
  const Vec3 force = elastic.get(x).force;
  for (const double passed : {0.0, 0.001, 0.01, 0.1, 1.0}) {
    const Vec3 exact = truth.step(x, passed), filtered = filter.step(force, passed);
    CAPTURE(passed);
    CHECK((exact - filtered).norm() < 1e-8 * force.norm());
  }
}

TEST_CASE("viscous, nonlinear: the gap of presses at hand speed grows with their depth") {
  // Depths across and along the beam of 8 x 2 x 2 cm; the values are named in relaxation.hpp.
  const Gap shallow = gap_of(Vec3(0, 0, -0.002), 1), deep = gap_of(Vec3(0, 0, -0.012), 1),
            along = gap_of(Vec3(-0.008, 0, 0), 1);
  CAPTURE(shallow.filter, deep.filter, along.filter, shallow.most, deep.most, along.most);
  CHECK(shallow.without > 0.1);
  CHECK(deep.without > 0.1);
  CHECK(shallow.filter == Approx(0.00237).epsilon(0.02));
  CHECK(deep.filter == Approx(0.0108).epsilon(0.02));  // of the largest force
  CHECK(along.filter == Approx(0.0156).epsilon(0.02));
  // The steps of the solve are fine enough to tell.
  CHECK(gap_of(Vec3(0, 0, -0.012), 4).filter == Approx(deep.filter).epsilon(0.05));
}
