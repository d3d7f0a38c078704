#pragma once
// Shared by the commands that run experiments (`forefeel-bench`, the calibration of labels): a scene, given or
// built in, and states cached on disk between runs.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"

namespace forefeel {

// Shows progress: the share done, in [0, 1], and the current step.
using ShowShare = std::function<void(double, const std::string&)>;

class Laboratory {
 public:
  // scene: a file; "" selects the built-in scene. globals gives the overrides of the scene and takes the
  // warnings.
  Laboratory(const Globals& globals, const std::string& scene);

  const Scene& scene() const { return scene_; }
  const Globals& globals() const { return globals_; }
  std::string name() const { return scene_.source.file.string(); }

  // The solvable states of the lattice {k h}^3 in the box, ordered by distance from rest, solved to 1e-9 of
  // the force. Each is solved once and kept in a file of the cache folder; an incomplete file is completed.
  std::vector<State> lattice_states(const Box& box, double h, const ShowShare& show = {});
  // Tight solves on the reference branch (the primary equilibrium path), in the order of the positions; also
  // cached. A state without a solution is not usable().
  std::vector<State> references(std::span<const Vec3> at, const ShowShare& show = {});

  SessionInput session_input() const;  // from the scene, without known states

 private:
  const Globals& globals_;
  Scene scene_;
};

}  // namespace forefeel
