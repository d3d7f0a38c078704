#pragma once
// The discretisation error of a scene's body (solver/equilibrium/mesh_error.hpp), measured once per body, box
// and spacing and kept in the cache folder. Positions: halfway from rest to the faces of the box, into the body and
// along two directions across, because a slender body has its error in the directions in which it is soft.
//
//   MeshErrorTask mesh(scene, MeshErrorTask::When::meanwhile);   // at low priority beside a session
//   ...
//   summary.error.mesh = as_mesh(mesh.get());

#include <filesystem>
#include <future>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/console/document_keys.hpp"
#include "apps/scene/scene.hpp"
#include "solver/equilibrium/mesh_error.hpp"

namespace forefeel {

std::vector<Vec3> mesh_error_positions(const Box& box, const Vec3& inward, double spacing);

// Read from the cache if it is there. If `folder` is empty, nothing is cached. An error that could not be measured is
// not kept. Throws nothing: MeshError::why says what failed.
MeshError scene_mesh_error(const Scene& scene, const std::filesystem::path& folder,
                           std::stop_token stop = {});

// 12 % at 3 positions, against quadratic elements on the same mesh.
std::string in_words(const MeshError& error);
// by what it was measured, or why it was not: "3 equilibria of quadratic elements on the same mesh".
std::string measured_by(const MeshError& error);
// "discretisation error 12 % (…)". Ends with ", more than the error shown" where it is above `shown` [1].
std::string discretisation_line(const MeshError& error, double shown);
// discretisation_error, discretisation_positions, discretisation_by.
const JsonKeys<MeshError>& mesh_error_keys();

// One measurement, unless the scene has session.discretisation_error = false.
class MeshErrorTask {
 public:
  enum class When {
    meanwhile,  // from now on, in a thread of low priority
    at_the_end  // in get()
  };
  MeshErrorTask(const Scene& scene, When when);
  ~MeshErrorTask();  // stops the measurement
  MeshErrorTask(const MeshErrorTask&) = delete;
  MeshErrorTask& operator=(const MeshErrorTask&) = delete;

  // Waits for it. A raised interrupt (console/interrupt.hpp) ends it early.
  MeshError get();

 private:
  const Scene& scene_;
  std::filesystem::path folder_;
  std::stop_source stop_;
  std::future<MeshError> found_;
};

}  // namespace forefeel
