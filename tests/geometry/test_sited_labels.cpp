// Labels at (site, displacement): on a plane those of one state space, the same after any rotation, blind to the far
// side of a lobe and to far sites.
#include <Eigen/Geometry>

#include "geometry/coverage/sited_labels.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006, depth = 0.025, reach = 0.01;

StateSpaceOptions spaces() {
  StateSpaceOptions options;
  options.spacing = h;
  return options;
}

std::vector<SitedState> lattice_states(const Vec3& site, const Vec3& normal) {
  std::vector<SitedState> states;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = 0; k <= 3; ++k) states.push_back({site, normal, h * Vec3(i, j, -k)});
  return states;
}

std::vector<Vec3> drawn(int count) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> side(-0.02, 0.02);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back({side(random), side(random), side(random)});
  return points;
}

}  // namespace

TEST_CASE("Labels at one site are those of its states") {
  const std::vector<SitedState> states = lattice_states(Vec3(1, 2, 3), Vec3::UnitZ());
  SitedLabels labels(states, spaces(), depth, reach);
  StateSpaceOptions options = spaces();
  options.box = {Vec3::Constant(-depth), Vec3::Constant(depth)};
  StateSpace space(options);
  for (const SitedState& state : states) {
    State one;
    one.at = state.x;
    space.insert(std::move(one));
  }
  ByLabel<int> seen{};
  for (const Vec3& x : drawn(300)) {
    const Label label = labels.at({Vec3(1, 2, 3), Vec3::UnitZ(), x});
    CHECK(label == space.label(x));
    ++seen[label];
  }
  CHECK(seen[Label::safe] > 0);
  CHECK(seen[Label::blank] > 0);
  CHECK(labels.states_near() == states.size());
}

TEST_CASE("A turned body has the same labels, and only states known then count") {
  const Mat3 turn = Eigen::AngleAxisd(0.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<SitedState> states = lattice_states(Vec3::Zero(), Vec3::UnitZ()), turned = states;
  for (SitedState& state : turned) state = {turn * state.site, turn * state.normal, turn * state.x};
  SitedLabels labels(states, spaces(), depth, reach), other(turned, spaces(), depth, reach);
  int differ = 0;
  for (const Vec3& x : drawn(300)) {
    for (const std::size_t known : {std::size_t{40}, states.size()})
      CHECK(labels.at({Vec3::Zero(), Vec3::UnitZ(), x}, known) ==
            other.at({Vec3::Zero(), turn * Vec3::UnitZ(), turn * x}, known));
    differ += labels.at({Vec3::Zero(), Vec3::UnitZ(), x}, 40) != labels.at({Vec3::Zero(), Vec3::UnitZ(), x});
  }
  CHECK(differ > 10);
}

TEST_CASE("Far sites and the far side of a lobe label nothing") {
  SitedLabels labels(lattice_states(Vec3::Zero(), Vec3::UnitZ()), spaces(), depth, reach);
  const Vec3 x(0.001, 0.001, -0.009);
  CHECK(labels.at({Vec3(0.009, 0, 0), Vec3::UnitZ(), x}) == Label::safe);
  CHECK(labels.at({Vec3(0.05, 0, 0), Vec3::UnitZ(), x}) == Label::blank);
  CHECK(labels.at({Vec3(0.011, 0, 0), Vec3::UnitZ(), x}) == Label::blank);
  CHECK(labels.at({Vec3(0, 0, -0.003), -Vec3::UnitZ(), -x}) == Label::blank);
  CHECK(labels.states_near() == 0);
}
