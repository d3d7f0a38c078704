#include "apps/generate/solve_all.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>

#include "apps/scene/cache_folder.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/sha256.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/session/arrivals.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

// States that a run has solved, in the cache folder until it ends.
class KeptSolves {
 public:
  // Keeps nothing with few positions, without a cache folder, or while another process solves the same.
  KeptSolves(const Scene& scene, const std::optional<Vec3>& site, int jet, std::size_t positions);

  std::size_t size() const { return known_.size(); }  // of an earlier run
  const State* find(const Vec3& at) const;            // null: not solved yet
  void keep(const State& state);                      // by any thread; never throws for the file
  void remove();                                      // the result is complete

 private:
  using Place = std::tuple<double, double, double>;
  std::filesystem::path file_;
  std::map<Place, State> known_;
  std::mutex mutex_;
  std::unique_ptr<StateWriter> writer_;  // null: keeps nothing
};

constexpr std::size_t few_positions = 8;  // solved in seconds

std::string name_of_kept(const Scene& scene, const std::optional<Vec3>& site, int jet) {
  Sha256 hash;
  hash.add("solve").add(solver_revision()).add(scene.space.spacing).add(double(jet));
  hash.add(double(scene.kept.displacements));
  for (const auto& [key, value] : scene.identity) hash.add(key + "=" + value + "\n");
  if (site)
    for (int i = 0; i < 3; ++i) hash.add((*site)[i]);
  return hash.hex().substr(0, 32) + "-solves.states";
}

KeptSolves::KeptSolves(const Scene& scene, const std::optional<Vec3>& site, int jet, std::size_t positions) {
  const std::filesystem::path folder = cache_folder();
  if (folder.empty() || positions < few_positions) return;
  file_ = folder / name_of_kept(scene, site, jet);
  try {
    StateFile file = StateFile::open_or_create(
        file_,
        {.identity = scene.identity, .spacing = scene.space.spacing, .box = scene.space.box, .notes = {}});
    for (State& state : file.read_all()) {
      const Place place{state.at.x(), state.at.y(), state.at.z()};
      known_.insert_or_assign(place, std::move(state));
    }
    writer_ = std::make_unique<StateWriter>(std::move(file));
  } catch (const InputError&) {  // in use, or no room: the solves are merely not kept
    known_.clear();
  }
}

const State* KeptSolves::find(const Vec3& at) const {
  const auto found = known_.find({at.x(), at.y(), at.z()});
  return found == known_.end() ? nullptr : &found->second;
}

void KeptSolves::keep(const State& state) {
  const std::lock_guard lock(mutex_);
  if (!writer_) return;
  try {
    writer_->push(state);
  } catch (const InputError&) {
    writer_.reset();
  }
}

void KeptSolves::remove() {
  if (!writer_) return;
  writer_.reset();
  std::error_code ignored;
  for (const char* log : {"", "-wal", "-shm", "-lock"})
    std::filesystem::remove(file_.string() + log, ignored);
}

// The share of all solves that is done. Half of a state's share is its straight path, half the second path,
// which has up to three legs.
class Tally {
 public:
  Tally(const Globals& globals, std::size_t states) : progress_(globals, "solve"), parts_(states, 0.0) {
    show();
  }

  void straight(std::size_t i, double share) { set(i, 0.5 * share); }
  void second(std::size_t i, int leg, double share) { set(i, 0.5 + (leg + share) / 6); }
  void done(std::size_t i) {
    ++done_;
    set(i, 1);
  }

 private:
  void set(std::size_t i, double part) {
    const std::lock_guard lock(mutex_);
    sum_ += part - parts_[i];
    parts_[i] = part;
    show();
  }
  void show() {
    progress_.show(sum_ / static_cast<double>(parts_.size()),
                   fmt::format("{} of {} states", done_.load(), parts_.size()));
  }

  Progress progress_;
  std::mutex mutex_;
  std::vector<double> parts_;
  std::atomic<std::size_t> done_ = 0;
  double sum_ = 0;
};

}  // namespace

std::vector<SolveOutcome> solve_all(const Scene& scene, const std::vector<Vec3>& points,
                                    const std::optional<Vec3>& site, int jet, const Globals& globals) {
  KeptSolves kept(scene, site, jet, points.size());
  if (kept.size() > 0)
    say(globals, fmt::format("{} of an earlier run, ended early, {} kept", counted(kept.size(), "state"),
                             kept.size() == 1 ? "is" : "are"));
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  std::vector<SolveOutcome> outcomes(points.size());
  Tally tally(globals, points.size());
#pragma omp parallel num_threads( \
    static_cast <int>(std::min <std::size_t>(points.size(), static_cast <std::size_t>(threads))))
  {
    Solver solver(scene.body);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (const State* known = kept.find(points[i])) {
        outcomes[i].state = *known;
        tally.done(i);
        continue;
      }
      solver.watch([&tally, i](double share) { tally.straight(i, share); });
      outcomes[i] = solver.reference(points[i], scene.space.spacing,
                                     {.want_displacements = scene.kept.displacements, .jet = jet});
      State& state = outcomes[i].state;
      int leg = 0;
      solver.watch([&tally, &leg, i](double share) {
        tally.second(i, leg, share);
        leg += share >= 1;
      });
      state.force.array() += 0.0;  // no -0, which a file of states does not keep
      state.solve.multivalued = second_way_differs(solver, state, scene.space.spacing);
      if (state.solve.multivalued)
        outcomes[i].warnings.push_back("another path ends in another stable equilibrium here");
      solver.watch({});
      if (outcomes[i].warnings.empty()) kept.keep(state);  // a file of states holds no warnings
      tally.done(i);
    }
  }
  kept.remove();
  return outcomes;
}

}  // namespace forefeel
