// States of your own -> labels. Usage: own_states [STATES.csv], columns x,y,z,fx,fy,fz [m, N].

#include <fmt/format.h>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

// Measured forces of a spring of 200 N/m on a lattice with a hole of 5 cm along x.
std::vector<State> measured(double spacing) {
  std::vector<State> states;
  for (const Vec3& at : lattice({Vec3(-0.05, -0.01, -0.01), Vec3(0.05, 0.01, 0.01)}, spacing)) {
    State state;
    state.at = at;
    state.force = -200 * at;
    if (std::abs(at.x()) > 0.02) states.push_back(state);
  }
  return states;
}

int main(int argc, char** argv) try {
  // 1. The states, and the spacing at which they count as dense.
  const double spacing = 0.005;  // [m]
  const std::vector<State> states = argc > 1 ? read_states_csv(argv[1]) : measured(spacing);

  // 2. The space finds neighbours and labels. Of states at the same position, only the first is kept.
  StateSpace space({.spacing = spacing});
  for (const State& state : states) space.insert(state);

  // 3. The label along a line: safe (dense), sparse (near), gap (between known regions), blank (beyond).
  for (double x = -0.08; x < 0.0801; x += 0.01) {
    const Coverage here = space.coverage(Vec3(x, 0, 0));
    fmt::print("x = {:4.0f} mm: {:6}, nearest state {:4.1f} mm away\n", 1e3 * x, name(here.label),
               1e3 * here.delta);
  }
} catch (const InputError& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
