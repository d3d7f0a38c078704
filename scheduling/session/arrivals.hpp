#pragma once
// States that become known at given times: from a file of --arrivals, or as they did in an earlier run.

#include <filesystem>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/motion/trace.hpp"

namespace forefeel {

struct Arrival {
  double t = 0;            // [s]
  Vec3 at = Vec3::Zero();  // [m]
};

// CSV t,x,y,z; sorted by time. InputError names file and line of a place farther than `farthest` from rest
// [m].
std::vector<Arrival> read_arrivals(const std::filesystem::path& file, double farthest);

struct Replay {
  Trace motion = {};
  std::vector<Arrival> arrivals = {};  // by time
  bool of_arrivals = false;            // nothing was solved in that run
};
// The files of an earlier run: frames.csv and, where something was dispatched, dispatch.csv.
Replay read_replay(const std::filesystem::path& run_folder, double farthest);

}  // namespace forefeel
