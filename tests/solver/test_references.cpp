// References computed with FEniCSx on a beam; skipped if the folder with them is missing.

#include "geometry/mesh/mesh_file.hpp"
#include "solver/body/law.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/test.hpp"

TEST_CASE("FEniCSx's beam: force within 1e-9, energy within 1e-9, every law") {
  const fs::path folder = fs::path(shared_folder()) / "beam";
  if (!fs::exists(folder / "beam.msh")) return skip("no reference data at " + folder.string());
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    fs::path reference = entry.path();
    if (reference.filename() ==
        "beam_MR_nu0.45.json")  // of the older form of the law, with lambda + 4 c2 at rest
      reference = folder.parent_path().parent_path() /
                  "cases/mooney-rivlin-at-small-strain/beam_MR_exact_nu0.45.json";
    if (!fs::exists(reference)) continue;
    INFO(reference);
    ++files;
    const auto document = json::parse(std::ifstream(reference));
    auto body = std::make_shared<Body>();
    body->mesh = read_mesh(folder / "beam.msh");
    const std::string law = document["law"];
    for (const Law candidate : all_laws())
      if (name(candidate) == law) body->material.law = candidate;
    REQUIRE(name(body->material.law) == law);
    body->material.young = document["material"]["E"];
    body->material.poisson = document["material"]["nu"];
    body->clamp = document["fixed_nodes"].get<std::vector<NodeIndex>>();
    body->contact = document["driven_nodes"].get<std::vector<NodeIndex>>();
    std::sort(body->clamp.begin(), body->clamp.end());
    std::sort(body->contact.begin(), body->contact.end());
    double rest_energy = 0;  // theirs counts sum V psi(F); psi(I) of the stable law is not zero
    if (body->material.law == Law::stable_neo_hookean) {
      const double mu = law_constants(body->material).mu, lambda = law_constants(body->material).lambda;
      const double m = 4 * mu / 3, l = lambda + 5 * mu / 6, a = 1 + m / l - m / (4 * l);
      rest_energy = mesh_quality(body->mesh).volume * (0.5 * l * (1 - a) * (1 - a) - 0.5 * m * std::log(4.0));
    }
    Solver solver(body);
    for (const auto& state : document["states"]) {
      const Vec3 x(state["at"][0], state["at"][1], state["at"][2]);
      const Vec3 force(state["force"][0], state["force"][1], state["force"][2]);
      const SolveOutcome outcome = solver.reference(x, 0.006);
      REQUIRE(outcome.state.solve.status == SolveStatus::converged);
      INFO(x.transpose() << ": " << outcome.state.force.transpose() << ", theirs " << force.transpose());
      CHECK((outcome.state.force - force).norm() < 1e-9 * force.norm());
      const double energy = state["energy"].get<double>() - rest_energy;
      CHECK(std::abs(outcome.state.energy - energy) <
            1e-9 * std::abs(energy) + 1e-14 * std::abs(rest_energy));
    }
  }
  CHECK(files > 0);
}
