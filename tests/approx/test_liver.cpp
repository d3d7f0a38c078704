// Extrapolation beyond a flat front of states of a liver, against tight solves. If ../shared exists, its liver is used,
// with the errors that were measured on it before this library was written; else the phantom.

#include "approx/model/updater.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"
#include "tests/support/test.hpp"

namespace {

const fs::path shared_liver = source_folder() / "../shared/data/liver";

// The list after "nodes = [" in a section of a scene.
std::vector<NodeIndex> nodes_of(const std::string& scene, const std::string& section) {
  const auto from = scene.find("nodes = [", scene.find("[" + section + "]")) + 9;
  std::string list = scene.substr(from, scene.find(']', from) - from);
  std::ranges::replace(list, ',', ' ');
  std::istringstream in(list);
  std::vector<NodeIndex> nodes;
  for (long long node; in >> node;) nodes.push_back(static_cast<NodeIndex>(node));
  std::ranges::sort(nodes);
  return nodes;
}

struct LiverStates {
  bool real = false;
  double h = 0.006, front = -0.012;
  std::vector<State> states;                // x <= front
  std::vector<std::vector<State>> outside;  // 1, 2, 3, 4 spacings out
};

const LiverStates& liver_states() {
  static const LiverStates made = [] {
    LiverStates g;
    auto body = std::make_shared<Body>();
    g.real = fs::exists(shared_liver / "liver_patch.toml");
    if (g.real) {
      std::ifstream in(shared_liver / "liver_patch.toml");
      const std::string scene{std::istreambuf_iterator<char>(in), {}};
      body->mesh = read_mesh(shared_liver / "liver_1777.msh");
      body->clamp = nodes_of(scene, "clamp");
      body->contact = nodes_of(scene, "contact");
    } else {
      body->mesh = phantom("liver");
      body->clamp = body->mesh.groups.at("clamp");
      body->contact = body->mesh.groups.at("contact");
    }
    LatticeOptions generate;
    generate.spacing = g.h;
    generate.box = {Vec3(-0.036, -0.036, -0.024), Vec3(g.front, 0.036, 0.036)};
    generate.threads = 1;
    generate_lattice(body, generate, [&](State s) {
      if (s.usable()) g.states.push_back(std::move(s));
    });
    Solver solver(body);
    for (int out = 1; out <= 4; ++out) {
      g.outside.emplace_back();
      for (int i = -3; i <= 3; ++i)
        for (int k = -3; k <= 3; ++k) {
          const Vec3 x(g.front + out * g.h, g.h * i, g.h * k);
          if (x.norm() < 1e-9) continue;  // rest, where a relative error says nothing
          const State state = solver.reference(x, g.h).state;
          if (state.usable()) g.outside.back().push_back(state);
        }
    }
    return g;
  }();
  return made;
}

struct Row {
  Kernel kernel;
  Data data;
  std::size_t n;
  double p50[2], most[2];  // at 6 and 12 mm
};
const std::vector<Row> rows = {
    {Kernel::linear, Data::force, 100, {.031, .090}, {.080, .295}},
    {Kernel::cubic, Data::force, 100, {.010, .040}, {.029, .142}},
    {Kernel::quintic, Data::force, 100, {.005, .032}, {.023, .108}},
    {Kernel::cubic, Data::force_and_stiffness, 25, {.005, .032}, {.015, .103}},
    {Kernel::quintic, Data::force_and_stiffness, 25, {.001, .011}, {.003, .037}},
    {Kernel::quintic, Data::force_and_stiffness, 100, {.001, .007}, {.002, .022}},
};

StateSpace space_of(const LiverStates& g) {
  StateSpaceOptions options;
  options.spacing = g.h;
  StateSpace space(options);
  for (const State& s : g.states) space.insert(s);
  return space;
}

}  // namespace

// The table's last digit is half a unit wide.
TEST_CASE("A liver's flat front: one and two spacings out no worse than was measured before", "[liver]") {
  const LiverStates& g = liver_states();
  REQUIRE(g.states.size() > 400);
  if (!g.real) return skip("no reference data beside the sources");
  const StateSpace space = space_of(g);
  for (const Row& row : rows)
    for (std::size_t out = 0; out < 2; ++out) {
      ModelUpdater updater(space, {.kernel = row.kernel, .data = row.data, .neighbours = row.n});
      std::vector<double> errors;
      for (const State& s : g.outside[out]) {
        updater.forget();
        errors.push_back((updater.model_at(s.at).force(s.at) - s.force).norm() /
                         std::max(s.force.norm(), 0.05));
      }
      REQUIRE(errors.size() >= 48);
      std::ranges::sort(errors);
      const double p50 = errors[errors.size() / 2], most = errors.back();
      CAPTURE(name(row.kernel), name(row.data), row.n, 6 * (out + 1), p50, most);
      CHECK(p50 <= row.p50[out] + 0.0005);
      CHECK(most <= row.most[out] + 0.0005);
    }
}

TEST_CASE("A liver's flat front: however far out, with whatever set, finite and below the bound", "[liver]") {
  const LiverStates& g = liver_states();
  const StateSpace space = space_of(g);
  for (const auto& [kernel, data] : {std::pair{Kernel::linear, Data::force},
                                     {Kernel::cubic, Data::force},
                                     {Kernel::quintic, Data::force},
                                     {Kernel::cubic, Data::force_and_stiffness},
                                     {Kernel::quintic, Data::force_and_stiffness}})
    for (const Select select : {Select::label, Select::nearest})
      for (const std::size_t n : {4, 8, 25, 50, 100, 300}) {
        if (data == Data::force_and_stiffness && n > 100) continue;
        CAPTURE(name(kernel), name(data), name(select), n);
        ModelUpdater updater(space, {.kernel = kernel, .data = data, .neighbours = n, .select = select});
        Model model;
        for (const double out : {0.006, 0.012, 0.018, 0.024, 0.036, 0.06, 0.12})
          for (const Vec3& aside : {Vec3(0, 0, 0), Vec3(0, 0.011, -0.007), Vec3(0, 0.05, 0.06)}) {
            const Vec3 hip = aside + Vec3(g.front + out, 0, 0);
            updater.update(hip, model);
            double force = 0, stiffness = 0;
            for (const StateId id : model.states()) {
              force = std::max(force, space[id].force.norm());
              stiffness = std::max(stiffness, space[id].stiffness.norm());
            }
            CHECK(model.force_bound() <= 1.25 * (force + stiffness * model.hold_distance()) * (1 + 1e-12));
            for (const double by : {-0.02, 0.0, 0.003, 0.02, 0.3})
              CHECK(model.force(hip + Vec3(by, 0.3 * by, -0.2 * by)).norm() <=
                    model.force_bound());  // false for NaN
          }
      }
}
