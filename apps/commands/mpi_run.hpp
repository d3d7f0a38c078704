#pragma once
// Commands that run as all ranks of `mpirun -n N forefeel COMMAND … --mpi`. Rank 0 reads, writes and speaks; the other
// ranks load the same input and solve what rank 0 gives them.

#include <functional>
#include <string>

#include "apps/console/command.hpp"
#include "apps/console/console.hpp"
#include "apps/scene_input/scene.hpp"
#include "scheduling/farm/rank_pool.hpp"
#include "scheduling/farm/rank_server.hpp"

namespace forefeel {

struct MpiArguments {
  bool on = false;
  double patience = 10;  // [s]
};
void add_mpi_options(Command& command, MpiArguments& arguments, const std::string& help);

struct RankedCommand {
  std::function<int(RankPool&)> lead;  // rank 0; returns the exit code
  LoadHand load;                       // the other ranks
  bool load_at_once = false;           // the other ranks do not wait for rank 0 to check the input
};
// Throws what lead() throws. Ranks that hang at the end are left behind: mpirun ends them.
int run_ranked(const Globals& globals, const MpiArguments& arguments, const RankedCommand& command);

// A measured spacing takes hundreds of solves: rank 0 measures it and says it when the work begins. heard: the
// scene's spacing, or what rank 0 said where the scene's is "auto". Throws where the run ends before.
Bytes said_spacing(double spacing);
double heard_spacing(const Scene& scene, const RankContext& rank);

// What ranks of one run have in common: the build and the content of their input.
std::string rank_identity(const std::string& content_hash);

}  // namespace forefeel
