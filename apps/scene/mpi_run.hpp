#pragma once
// Commands that run on all ranks of `mpirun -n N forefeel COMMAND … --mpi`. Rank 0 reads, writes and prints. The other
// ranks load the same input and solve the jobs that rank 0 gives them.

#include <functional>
#include <string>

#include "apps/console/command.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "scheduling/workers/rank_pool.hpp"
#include "scheduling/workers/rank_server.hpp"

namespace forefeel {

struct MpiArguments {
  bool on = false;
  double patience = 10;  // [s]
};
void add_mpi_options(Command& command, MpiArguments& arguments, const std::string& help);

struct RankedCommand {
  std::function<int(RankPool&)> lead;  // rank 0; returns the exit code
  LoadWorker load;                     // the other ranks
  bool load_at_once = false;           // the other ranks do not wait for rank 0 to check the input
};
// Rethrows exceptions of lead(). If ranks hang at the end, it does not wait for them: mpirun ends them.
int run_ranked(const Globals& globals, const MpiArguments& arguments, const RankedCommand& command);

// Measuring a spacing takes hundreds of solves, so only rank 0 measures it and sends it when the work begins.
// pack_spacing() packs that message. received_spacing() returns the scene's spacing or, if that is "auto", the one from
// rank 0; it throws if the run ends before.
Bytes pack_spacing(double spacing);
double received_spacing(const Scene& scene, const RankContext& rank);

// Identity that all ranks of one run must share: of the build and of the content of the input.
std::string rank_identity(const std::string& content_hash);

}  // namespace forefeel
