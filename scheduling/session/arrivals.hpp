#pragma once
// States that become known at given times, read from a file (--arrivals) or from an earlier run (--replay).

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/motion/trace.hpp"

namespace forefeel {

struct Arrival {
  double t = 0;            // [s]
  Vec3 at = Vec3::Zero();  // [m]
  // Of a body that is touched anywhere; `at` is then the displacement there. In a file of positions of the tip it is
  // none at first: the nearest place is taken (make_plan).
  SurfacePlace site = {};
};

// Reads CSV t,x,y,z and sorts by time. InputError with file and line for a position farther than `farthest`
// [m] from rest.
std::vector<Arrival> read_arrivals(const std::filesystem::path& file, double farthest);

// "is 20 m from rest, expected at most 0.4 m, twice the body's length". If it is much farther, the text also asks
// about the unit.
std::string too_far(double distance, double farthest);

struct Replay {
  Trace motion = {};
  std::vector<Arrival> arrivals = {};  // by time
  bool of_arrivals = false;            // the earlier run used --arrivals itself
  bool anywhere = false;               // its body was touched anywhere: positions are those of the mesh
};
// Reads the files of an earlier run: frames.csv and, if states were dispatched, dispatch.csv.
Replay read_replay(const std::filesystem::path& run_folder, double farthest);

}  // namespace forefeel
