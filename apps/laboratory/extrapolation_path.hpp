#pragma once
// The paths of the paper's Fig. 2. Each path leaves the known region. For each method and situation it has
// - the force along the path,
// - its error against the complete state space (the same method with all states known),
// - its error against tight solves,
// - the jump of the force where the neighbour set changes:
//   jump at x_i = |M_i(x_i) - M_{i-1}(x_i)| [N],  M_i the model made from the neighbours of x_i.

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "apps/laboratory/paper_states.hpp"

namespace forefeel::fig2 {

struct PathPoint {
  double s = 0;  // [m]
  Vec3 force = Vec3::Zero(), complete = Vec3::Zero();
  Label label = Label::blank;
  double jump = 0;                          // [N]
  std::size_t near_side = 0, far_side = 0;  // states of the set before and beyond the middle of the gap
  double error_complete = unknown, error_tight = unknown;
};

struct Curve {
  std::string setup;
  PathMethod method;
  std::vector<PathPoint> points;
};

struct Judge {
  double floor, share, absolute;  // f0 [N]; of the JND
  double relative(const Vec3& force, const Vec3& truth) const {
    return (force - truth).norm() / std::max(truth.norm(), floor);
  }
  double in_jnd(double jump, const Vec3& force) const {
    return jump / std::max(share * force.norm(), absolute);
  }
};

struct Fig2 {
  std::vector<Curve> curves;
  std::size_t asked = 0;  // number of tight solves tried; the solutions follow
  std::vector<double> tight_s;
  std::vector<Vec3> tight;
};

// Runs every method in every situation.
Fig2 run_all(Laboratory& laboratory, const PaperStates& paper, const Judge& judge, const ShowShare& show);

struct Jump {
  double s = unknown, size = 0, jnd = 0;  // [m], [N], in JND
};

// The largest jump in newtons and the largest in JND, over low < s <= high. They may be different jumps.
struct Largest {
  Jump newton, jnd;
};
Largest largest(const Curve& curve, const Judge& judge, double low = 0,
                double high = std::numeric_limits<double>::infinity());

// The jumps where the neighbour set gains its first states of the far side, and where it loses its last states of the
// near side.
struct Crossing {
  Jump enters, leaves;
};
Crossing crossing(const Curve& curve, const Judge& judge);

// Relative errors up to s = high [m]: against tight solves (NaN if there is none), or against the complete
// state space.
std::vector<double> errors(const Curve& curve, bool tight,
                           double high = std::numeric_limits<double>::infinity());
double at_end(const std::vector<double>& values);  // the last finite value

}  // namespace forefeel::fig2
