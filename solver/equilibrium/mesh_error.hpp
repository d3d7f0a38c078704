#pragma once
// Discretisation error: what the mesh itself gets wrong. No comparison with a solve on the same mesh shows it.
// It is estimated at positions x_i [m] by a finer body,
//   e = max_i |f(x_i) - f*(x_i)| / |f*(x_i)|
// f: force of the body [N]; f*: that of the finer one,
//   of linear elements      quadratic elements on the same mesh
//   of quadratic elements   quadratic elements on the mesh with each tetrahedron in eight (refined_body.hpp)
// The true discretisation error is larger than e: e contains neither the error of the finer body nor the difference
// between mesh and true shape. Only the size of the finer body decides how it is solved. So time and memory are bounded
// and the value is the same on every machine:
//   to most_for_equilibria nodes   equilibria at x_i, reached straight from rest
//   to most_nodes                  the stiffness at rest, f = -K x_i: one factorisation of each body
//   beyond                         not measured
// A body with a fine jet (fine_jet.hpp) is compared with a finer body instead: FineJet::error_left() gives e and
// an interval at each position nearer than 0.8 rho. mesh_errors() gives none where its quadratic body creases (least
// det F below 0.7); the largest of many positions counts them.

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

class Solver;

std::shared_ptr<const Body> finer_body(const Body& body);
std::int64_t nodes_of_finer(
    const Body& body);  // without making it; mid-edge nodes included, a few per cent off
std::string_view finer_in_words(const Body& body);  // "quadratic elements on the same mesh"

enum class MeshErrorMethod { none, equilibria, rest, fine };
std::string_view name(MeshErrorMethod method);  // "none", "equilibria", "rest stiffness", "fine bodies"

struct MeshErrorOptions {
  double spacing = 0;  // of the continuation steps [m], > 0
  std::int64_t most_for_equilibria = 6'000, most_nodes = 20'000;
  std::stop_token stop = {};  // looked at between iterations
};

struct MeshError {
  double error = unknown;     // e [1]
  std::size_t positions = 0;  // at which it was measured
  MeshErrorMethod method = MeshErrorMethod::none;
  double low = unknown,
         high = unknown;   // an interval for e; without a fine body e is a lower bound, and high unknown
  std::string finer = {};  // finer_in_words()
  std::string why = {};    // not measured; empty where it was
  bool stopped = false;
};

// Positions at rest do not count. Throws nothing but std::bad_alloc; if nothing could be measured, `why` says why.
MeshError mesh_error(const std::shared_ptr<const Body>& body, std::span<const Vec3> positions,
                     const MeshErrorOptions& options);

// e and its interval at the position of each state; unknown where one of the two bodies is not solved, at rest, and
// where a fine jet claims nothing.
std::vector<ForceError> mesh_errors(const Body& body, std::span<const State> states, double spacing);

// One line for a state that is solved, away from rest and without an error; empty otherwise.
std::string why_no_error(const Body& body, const State& state, const ForceError& error);

}  // namespace forefeel
