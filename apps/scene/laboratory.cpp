#include "apps/scene/laboratory.hpp"

#include <fmt/format.h>

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/scene_session.hpp"
#include "solver/lattice/cached_lattice.hpp"

namespace forefeel {

Laboratory::Laboratory(const Globals& globals, const std::string& scene)
    : globals_(globals),
      scene_(scene.empty() ? built_in_scene(globals.set) : load_scene(scene, globals.set)),
      built_in_(scene.empty()) {
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

const std::shared_ptr<ReferenceService>& Laboratory::service() {
  if (service_) return service_;
  service_ = std::make_shared<ReferenceService>(reference_options(session_input()), globals_.threads);
  if (service_->damage()) warn(globals_, *service_->damage());
  return service_;
}

std::vector<State> Laboratory::references(std::span<const Vec3> at, const ShowShare& show) {
  ReferenceService& solver = *service();
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
  input.references = service_;
  return input;
}

Mat3 lattice_frame(const Vec3& inward) {
  Eigen::Index axis = 0;
  inward.cwiseAbs().maxCoeff(&axis);
  Mat3 frame = Mat3::Zero();
  frame(axis, 0) = inward[axis] < 0 ? -1 : 1;
  frame((axis + 1) % 3, 1) = 1;
  frame((axis + 2) % 3, 2) = 1;
  return frame;
}

}  // namespace forefeel
