// Rate-dependent tissue: the relaxation filter against closed forms and against a time-stepped finite-element solve
// with internal stresses in every element, assembled here.
#include <Eigen/Dense>

#include "approx/switch/relaxation.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

const Viscosity two_branches{{0.3, 0.03}, {0.25, 0.4}};

// Linear tetrahedra of a generalised Maxwell solid, h' = g C eps' - h / tau in each element and branch, by the
// trapezoidal rule: another integrator than the filter's. Bulk and shear may relax by different shares.
class MaxwellBody {
 public:
  MaxwellBody(const Body& body, const Viscosity& shear, bool bulk_relaxes) : body_(body), branches_(shear) {
    const double e = body.material.young, nu = body.material.poisson;
    const double mu = e / (2 * (1 + nu)), kappa = e / (3 * (1 - 2 * nu));
    Mat6 volumetric = Mat6::Zero();
    volumetric.topLeftCorner<3, 3>().setConstant(kappa);
    Mat6 deviatoric = Mat6::Zero();
    deviatoric.diagonal() << 2, 2, 2, 1, 1, 1;
    deviatoric.topLeftCorner<3, 3>().array() -= 2.0 / 3;
    deviatoric *= mu;
    long_term_ = volumetric + deviatoric;
    for (const MaxwellBranch& branch : branches_) {
      relaxing_.push_back(branch.share * (deviatoric + (bulk_relaxes ? volumetric : Mat6::Zero())));
      long_term_ -= relaxing_.back();
    }
    const auto nodes = static_cast<Eigen::Index>(body.mesh.nodes.size());
    std::vector<int> role(body.mesh.nodes.size(), 0);
    for (const NodeIndex n : body.clamp) role[static_cast<std::size_t>(n)] = 1;
    for (const NodeIndex n : body.contact) role[static_cast<std::size_t>(n)] = 2;
    for (Eigen::Index n = 0; n < nodes; ++n)
      for (int i = 0; i < 3; ++i)
        if (role[static_cast<std::size_t>(n)] == 0) free_.push_back(static_cast<int>(3 * n + i));
    for (const Tet& tet : body.mesh.tets) add(tet);
    u_ = Eigen::VectorXd::Zero(3 * nodes);
  }

  // Moves the contact to x within `passed` [s]; 0: at once. Returns the force on the tip [N].
  Vec3 step(const Vec3& x, double passed) {
    std::vector<double> r, q;
    Mat6 tangent = long_term_;
    for (std::size_t b = 0; b < branches_.size(); ++b) {
      const double a = passed / branches_[b].time;
      r.push_back((1 - a / 2) / (1 + a / 2));
      q.push_back(1 / (1 + a / 2));
      tangent += q[b] * relaxing_[b];
    }
    if (passed != factored_for_) factor(tangent, passed);
    Eigen::VectorXd next = u_;
    for (const NodeIndex n : body_.contact) next.segment<3>(3 * n) = x;
    // The contact moves first, then the free nodes restore the equilibrium: the problem is linear.
    Eigen::VectorXd force = internal(next, r, q, false);
    const Eigen::VectorXd moved = factor_.solve(-force(free_));
    for (std::size_t i = 0; i < free_.size(); ++i) next[free_[i]] += moved[static_cast<Eigen::Index>(i)];
    force = internal(next, r, q, true);
    u_ = next;
    Vec3 tip = Vec3::Zero();
    for (const NodeIndex n : body_.contact) tip -= force.segment<3>(3 * n);
    return tip;
  }

 private:
  struct Element {
    std::array<int, 12> dofs;
    Eigen::Matrix<double, 6, 12> b;
    double volume;
    std::vector<Vec6> stress;  // by branch
  };

  void add(const Tet& tet) {
    Element element;
    Eigen::Matrix4d corners;
    for (int i = 0; i < 4; ++i) {
      corners.row(i) << 1,
          body_.mesh.nodes[static_cast<std::size_t>(tet[static_cast<std::size_t>(i)])].transpose();
      for (int k = 0; k < 3; ++k)
        element.dofs[static_cast<std::size_t>(3 * i + k)] = 3 * tet[static_cast<std::size_t>(i)] + k;
    }
    element.volume = std::abs(corners.determinant()) / 6;
    const Eigen::Matrix4d inverse = corners.inverse();
    element.b.setZero();
    for (int i = 0; i < 4; ++i) {
      const Vec3 g = inverse.block<3, 1>(1, i);
      element.b.block<6, 3>(0, 3 * i) << g[0], 0, 0, 0, g[1], 0, 0, 0, g[2], g[1], g[0], 0, 0, g[2], g[1],
          g[2], 0, g[0];
    }
    element.stress.assign(branches_.size(), Vec6::Zero());
    elements_.push_back(element);
  }

  void factor(const Mat6& tangent, double passed) {
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * body_.mesh.nodes.size()),
                                                  static_cast<Eigen::Index>(3 * body_.mesh.nodes.size()));
    for (const Element& e : elements_) whole(e.dofs, e.dofs) += e.volume * e.b.transpose() * tangent * e.b;
    factor_.compute(Eigen::MatrixXd(whole(free_, free_)));
    factored_for_ = passed;
  }

  Eigen::VectorXd internal(const Eigen::VectorXd& next, const std::vector<double>& r,
                           const std::vector<double>& q, bool keep) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(next.size());
    for (Element& e : elements_) {
      const Vec6 now = e.b * next(e.dofs), change = now - e.b * u_(e.dofs);
      Vec6 stress = long_term_ * now;
      for (std::size_t b = 0; b < branches_.size(); ++b) {
        const Vec6 h = r[b] * e.stress[b] + q[b] * (relaxing_[b] * change);
        stress += h;
        if (keep) e.stress[b] = h;
      }
      force(e.dofs) += e.volume * e.b.transpose() * stress;
    }
    return force;
  }

  const Body& body_;
  const Viscosity branches_;
  Mat6 long_term_;
  std::vector<Mat6> relaxing_;
  std::vector<Element> elements_;
  std::vector<int> free_;
  Eigen::VectorXd u_;
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  double factored_for_ = -1;
};

// Forces of that body in each frame, with the tip on a straight line between frames.
std::vector<Vec3> stepped(MaxwellBody& body, const std::vector<FrameRecord>& frames, int steps) {
  std::vector<Vec3> forces{body.step(frames[0].at, 0)};
  const double passed = 1e-3 / steps;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    Vec3 force = Vec3::Zero();
    for (int i = 1; i <= steps; ++i)
      force = body.step(frames[k - 1].at + (frames[k].at - frames[k - 1].at) * i / steps, passed);
    forces.push_back(force);
  }
  return forces;
}

// The lattice states about rest are known from the start.
SessionInput known_input(Law law) {
  SessionInput input = small_input(law);
  ReferenceService service(reference_options(input), 1);
  for (const Vec3& x : lattice(input.touched.space.box, input.touched.space.spacing))
    input.known.push_back(service.get(x));
  return input;
}

SessionOptions moving(double seconds) {
  SessionOptions options = virtual_options(seconds);
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.06};
  options.switching.rule = SwitchRule::none;
  return options;
}

double largest(const std::vector<FrameRecord>& frames) {
  double most = 0;
  for (const FrameRecord& f : frames) most = std::max(most, f.force.norm());
  return most;
}

}  // namespace

TEST_CASE("relaxation: a held step, a ramp, unequal steps and steps left out follow the closed form") {
  const Vec3 one(1, -2, 0.5);
  RelaxationFilter held(two_branches);
  double t = 0;
  for (const double dt : {0.0, 0.001, 0.01, 0.003, 0.5, 2.0}) {
    t += dt;
    CHECK((held.step(one, dt) - relaxation(two_branches, t) * one).norm() < 1e-14);
  }
  // A ramp of slope 1: the integral of G. Steps of 1 ms and one of 7 ms give the same.
  const auto integral = [&](double time) {
    double value = long_term_share(two_branches) * time;
    for (const MaxwellBranch& b : two_branches) value += b.share * b.time * (1 - std::exp(-time / b.time));
    return value;
  };
  RelaxationFilter fine(two_branches), coarse(two_branches);
  fine.step(Vec3::Zero(), 0), coarse.step(Vec3::Zero(), 0);
  Vec3 last = Vec3::Zero();
  for (int k = 1; k <= 7; ++k) last = fine.step(0.001 * k * one, 0.001);
  CHECK((last - integral(0.007) * one).norm() < 1e-15);
  CHECK((coarse.step(0.007 * one, 0.007) - last).norm() < 1e-15);
}

TEST_CASE(
    "relaxation: a force held constant creeps, and a loop loses energy, as of the standard linear solid") {
  constexpr double g = 0.4, tau = 0.2, frame = 1e-3;
  // Creep: the elastic force that keeps F = 1 is the compliance J(t) = 1 / (1 - g) - g / (1 - g) exp(-(1 - g) t / tau).
  RelaxationFilter creep({{g, tau}});
  creep.step(Vec3::UnitX(), 0);
  for (int k = 1; k <= 2000; ++k) {
    RelaxationFilter none = creep,
                     one = creep;  // the filter is linear: two steps give the one that is wanted
    const double without = none.step(Vec3::Zero(), frame).x(), with = one.step(Vec3::UnitX(), frame).x();
    const double elastic = (1 - without) / (with - without);
    creep.step(Vec3(elastic, 0, 0), frame);
    CHECK(elastic == Approx((1 - g * std::exp(-(1 - g) * k * frame / tau)) / (1 - g)).epsilon(1e-5));
  }
  // A settled loop of sin(w t): the loss modulus is g w tau / (1 + w^2 tau^2), of second order in the frame.
  const auto lost = [&](int frames) {
    constexpr double turn = 2 * M_PI * tau;  // w tau, of a period of 1 s
    RelaxationFilter loop({{g, tau}});
    double work = 0, last = 0, before = 0;
    for (int k = 0; k <= 5 * frames; ++k) {
      const double place = std::sin(2 * M_PI * k / frames),
                   force = loop.step(Vec3(place, 0, 0), 1.0 / frames).x();
      if (k > 4 * frames) work += 0.5 * (force + last) * (place - before);
      last = force, before = place;
    }
    return work / (M_PI * g * turn / (1 + turn * turn)) - 1;
  };
  CHECK(std::abs(lost(1000)) < 1e-4);
  CHECK(lost(100) / lost(400) == Approx(16).epsilon(0.1));
}

TEST_CASE("relaxation: a force that is not finite leaves no trace") {
  RelaxationFilter with(two_branches), without(two_branches);
  const Vec3 a(1, 0, 0), b(3, 1, 0);
  with.step(a, 0), without.step(a, 0);
  CHECK_FALSE(with.step(Vec3::Constant(NAN), 0.001).allFinite());
  CHECK(with.step(b, 0.002) == without.step(b, 0.003));
}

TEST_CASE("relaxation: shares and times that are none are named") {
  CHECK(problem_of({}).empty());
  CHECK(problem_of(two_branches).empty());
  CHECK_THAT(problem_of({{0.5, 1}, {0.5, 2}}), Contains("sum"));
  CHECK_THAT(problem_of({{0.5, 0}}), Contains("time"));
  CHECK_THAT(problem_of({{-0.1, 1}}), Contains("share"));
  SessionInput input = small_input(Law::linear);
  input.touched.viscosity = {{0.6, 1}, {0.6, 2}};
  CHECK_THROWS_AS(make_plan(input, virtual_options()), InputError);
}

TEST_CASE(
    "viscous session: a linear law gives the force of a time-stepped finite-element solve within 1e-6") {
  SessionInput input = known_input(Law::linear);
  input.touched.viscosity = two_branches;
  const SessionResult r = run_session(input, moving(0.6));
  REQUIRE(r.frames.size() == 600);
  CHECK(r.run.viscous);
  const double most = largest(r.frames);
  REQUIRE(most > 0.1);
  MaxwellBody body(*input.touched.body, two_branches, true);
  const std::vector<Vec3> oracle = stepped(body, r.frames, 20);
  double worst = 0, viscous = 0;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    worst = std::max(worst, (r.frames[k].force - oracle[k]).norm() / most);
    viscous = std::max(viscous, (r.frames[k].force - r.frames[k].elastic).norm() / most);
  }
  INFO("of the largest force, " << most << " N");
  CHECK(worst < 1e-6);
  CHECK(viscous > 0.1);  // else there was nothing to see
  std::size_t judged = 0;
  for (const FrameRecord& f : r.frames)
    if (std::isfinite(f.judged.error)) {
      ++judged;
      CHECK(f.judged.error < 1e-5);  // relative to the force, at least to 50 mN
      CHECK((f.judged.elastic_reference - f.elastic).norm() < 1e-6 * most);
    }
  CHECK(judged > 5);
}

TEST_CASE(
    "viscous session: where only shear relaxes, one relaxation function of the force is an approximation") {
  SessionInput input = known_input(Law::linear);
  input.touched.viscosity = two_branches;
  const SessionResult r = run_session(input, moving(0.6));
  MaxwellBody body(*input.touched.body, two_branches, false);
  const std::vector<Vec3> oracle = stepped(body, r.frames, 4);
  double gap = 0, elastic_gap = 0;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    gap = std::max(gap, (r.frames[k].force - oracle[k]).norm() / largest(r.frames));
    elastic_gap = std::max(elastic_gap, (r.frames[k].elastic - oracle[k]).norm() / largest(r.frames));
  }
  CHECK(gap == Approx(0.1356).epsilon(0.01));  // of the largest force; named in relaxation.hpp
  CHECK(gap < elastic_gap);                    // better than without the filter
}

TEST_CASE("viscous session: the reference between samples is that of tight solves in every frame") {
  SessionInput input = known_input(Law::neo_hookean);
  input.touched.viscosity = two_branches;
  const SessionResult r = run_session(input, moving(0.5));
  ReferenceService service(reference_options(input), 1);
  RelaxationFilter filter(two_branches);
  double worst = 0;
  for (const FrameRecord& f : r.frames) {
    const Vec3 exact = filter.step(service.get(f.at).force, 1e-3);
    if (f.judged.reference.allFinite()) worst = std::max(worst, (f.judged.reference - exact).norm());
  }
  CHECK(worst < 1e-5 * largest(r.frames));
}

TEST_CASE("elastic session: what is rendered is what the switch gave") {
  const SessionResult r = run_session(small_input(), virtual_options(0.2));
  CHECK_FALSE(r.run.viscous);
  for (const FrameRecord& f : r.frames) {
    REQUIRE(f.force == f.elastic);
    REQUIRE_FALSE(f.judged.elastic_reference.allFinite());
  }
}
