#include "apps/scene/laboratory.hpp"

#include <fmt/format.h>

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/scene_session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/lattice/cached_lattice.hpp"

namespace forefeel {

Laboratory::Laboratory(const Globals& globals, const std::string& scene)
    : globals_(globals),
      scene_(scene.empty() ? built_in_scene(globals.set) : load_scene(scene, globals.set)) {
  for (const std::string& warning : scene_.source.warnings) warn(globals, warning);
}

std::vector<State> Laboratory::lattice_states(const Box& box, double h, const ShowShare& show) {
  return cached_lattice_states(
      scene_.body, scene_.identity,
      {.spacing = h, .box = box, .threads = globals_.threads, .folder = cache_folder()},
      {.progress =
           [&](std::size_t done, std::size_t total) {
             if (show)
               show(static_cast<double>(done) / static_cast<double>(total),
                    fmt::format("{} of {} states", done, total));
           },
       .damaged = [&](const std::string& message) { warn(globals_, message); }});
}

std::vector<State> Laboratory::references(std::span<const Vec3> at, const ShowShare& show) {
  ReferenceService solver(reference_options(session_input()), globals_.threads);
  if (solver.damage()) warn(globals_, *solver.damage());
  for (const Vec3& x : at) solver.request(x);
  std::vector<State> states;
  for (const Vec3& x : at) {
    states.push_back(solver.get(x));
    if (show)
      show(static_cast<double>(states.size()) / static_cast<double>(at.size()),
           fmt::format("{} of {} tight solves", states.size(), at.size()));
  }
  return states;
}

SessionInput Laboratory::session_input() const {
  SessionInput input = forefeel::session_input(scene_);
  input.touched.displacements = false;
  input.touched.jet = 1;
  return input;
}

}  // namespace forefeel
