#include "apps/scene/mpi_run.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "apps/console/provenance.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/workers/mpi_group.hpp"

namespace forefeel {
namespace {

// The end of MPI waits for all ranks; if one is gone, this rank ends by itself after a while.
int serve(std::optional<MpiGroup>& group, const RankedCommand& command, double patience) {
  const ServedRank end = serve_rank(group->transport(), command.load, command.load_at_once);
  if (end == ServedRank::orphaned) std::_Exit(1);
  group->end_within(patience + 5, [] { std::_Exit(0); });
  if (end == ServedRank::busy) std::_Exit(0);  // the solving thread is never joined
  return 0;
}

// MPI cannot end properly while a rank hangs. Without a code, an error still has to be reported.
void end_with_hanging(const Globals& globals, MpiGroup& group, const RankPool& pool,
                      std::optional<int> code) {
  warn(globals, fmt::format("{} of {} ranks hang or are gone; mpirun ends them, and itself with an error",
                            pool.lost(), pool.ranks() + 1));
  if (!code) return group.abandon();
  flush_warnings();
  std::cout.flush();
  group.end_all(*code);
}

}  // namespace

void add_mpi_options(Command& command, MpiArguments& arguments, const std::string& help) {
  command.flag("--mpi", arguments.on, help);
  command
      .option("--patience", arguments.patience,
              "With --mpi: a rank that is silent for so long counts as hanging; its work goes to others [s]")
      .shows_default();
}

int run_ranked(const Globals& globals, const MpiArguments& arguments, const RankedCommand& command) {
  if (!MpiGroup::built())
    throw InputError("--mpi", "this build has no MPI, expected one made after `bash apps/setup.sh mpi`");
  std::optional<MpiGroup> group(std::in_place);
  if (group->rank() > 0) return serve(group, command, arguments.patience);
  RankPool pool(group->transport(), arguments.patience);
  std::exception_ptr failure;
  int code = 1;
  try {
    check_patience(arguments.patience);
    code = command.lead(pool);
  } catch (...) {
    failure = std::current_exception();
  }
  pool.stop();
  if (!pool.all_left())
    end_with_hanging(globals, *group, pool, failure ? std::nullopt : std::optional(code));
  else
    group->end_within(arguments.patience + 5, [code] {  // everything is written and reported
      std::cerr << "forefeel: warning: a rank hangs at the end of MPI; mpirun ends it\n";
      std::_Exit(code);
    });
  if (failure) std::rethrow_exception(failure);
  return code;
}

Bytes pack_spacing(double spacing) {
  Packer message;
  message.add(spacing);
  return message.take();
}

double received_spacing(const Scene& scene, const RankContext& rank) {
  if (!scene.spacing.automatic) return scene.space.spacing;
  std::optional<Bytes> message = rank.begun();
  if (!message) throw std::runtime_error("the run ended before it began");
  return Unpacker(std::move(*message)).number<double>();
}

std::string rank_identity(const std::string& content_hash) {
  const auto made_by = provenance(content_hash);
  return fmt::format("{} {} {}", made_by["version"].dump(), made_by["commit"].dump(), content_hash);
}

}  // namespace forefeel
