// forefeel bench solver elements: F(nu) / F(0.3) of a pressed liver phantom with four kinds of elements:
// linear tetrahedra; linear ones refined once (each into eight); quadratic ones; quadratic ones refined once,
// which are the reference. An element locks if its force rises too fast with nu. Time and number of free
// nodes show the cost.

#include <fmt/format.h>
#include <omp.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/bench/bench_elements.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene/scene_body.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {
namespace {

constexpr double ratios[] = {0.3, 0.4, 0.45, 0.49, 0.499};
constexpr double depth = 0.012, spacing = 0.006;  // [m]
constexpr std::size_t mesh_elements = 450;

struct Variant {
  const char* text;
  Element element;
  bool refined;
};
constexpr Variant variants[] = {{"linear", Element::linear, false},
                                {"linear, refined once", Element::linear, true},
                                {"quadratic", Element::quadratic, false},
                                {"quadratic, refined once", Element::quadratic, true}};
constexpr std::size_t reference = 3;

struct Measured {
  double force = 0, seconds = 0;
  std::int64_t free_nodes = 0;
  bool converged = false;
};

Measured measure(const Body& plain, const Variant& variant, double poisson, const Vec3& x) {
  auto body = std::make_shared<Body>(variant.refined ? refined(plain) : plain);
  body->element = variant.element;
  body->material.poisson = poisson;
  Solver solver(body);
  const State s = solver.reference(x, spacing).state;
  return {s.force.norm(), s.solve.seconds, discretise(*body).free_nodes,
          s.solve.status == SolveStatus::converged};
}

}  // namespace

int bench_elements(const Globals& globals) {
  Body plain;
  plain.mesh = phantom("liver", mesh_elements);
  plain.clamp = plain.mesh.groups.at("clamp");
  plain.contact = plain.mesh.groups.at("contact");
  std::sort(plain.clamp.begin(), plain.clamp.end());
  std::sort(plain.contact.begin(), plain.contact.end());
  const Vec3 x = depth * inward_direction(plain);
  constexpr std::size_t kinds = std::size(variants), count = kinds * std::size(ratios);
  std::array<Measured, count> all;
  Progress progress(globals, "bench solver elements");
  std::size_t done = 0;
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t turn = 0; turn < count; ++turn) {  // the longest first
    const std::size_t job = count - 1 - turn, kind = job % kinds;
    all[job] = measure(plain, variants[kind], ratios[job / kinds], x);
#pragma omp critical(forefeel_elements)
    progress.show(static_cast<double>(++done) / static_cast<double>(count),
                  fmt::format("{} of {}", done, count));
  }
  nlohmann::ordered_json document{{"rows", nlohmann::ordered_json::array()}};
  say(globals, fmt::format("Liver phantom, {} tetrahedra, neo-Hookean, 2 cm patch pressed by {:g} mm: force "
                           "over the refined quadratic "
                           "one, and F(nu)/F(0.3)",
                           plain.mesh.tets.size(), 1e3 * depth));
  say(globals, fmt::format("| element | free nodes | ms a state |{}", [] {
        std::string head;
        for (const double nu : ratios) head += fmt::format(" nu {} |", nu);
        return head;
      }()));
  say(globals, "|---|---|---|---|---|---|---|---|");
  bool converged = true;
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    std::string line = fmt::format("| {} | {} | {:.0f} |", variants[kind].text, all[kind].free_nodes,
                                   1e3 * all[kind].seconds);
    for (std::size_t i = 0; i < std::size(ratios); ++i) {
      const Measured& m = all[i * kinds + kind];
      const double error = m.force / all[i * kinds + reference].force - 1, rise = m.force / all[kind].force;
      converged = converged && m.converged;
      line += fmt::format(" {:+.1f} %, {:.2f} |", 100 * error, rise);
      document["rows"].push_back({{"element", variants[kind].text},
                                  {"poisson", ratios[i]},
                                  {"force", number(m.force)},
                                  {"error", number(error)},
                                  {"over_nu_0.3", number(rise)},
                                  {"free_nodes", m.free_nodes},
                                  {"seconds", number(m.seconds)},
                                  {"converged", m.converged}});
    }
    say(globals, line);
  }
  document["elements"] = plain.mesh.tets.size();
  document["provenance"] = provenance("");
  if (globals.json) print_json(document);
  if (converged) return 0;
  warn(globals, "some of the cases did not converge");
  return 1;
}

}  // namespace forefeel
