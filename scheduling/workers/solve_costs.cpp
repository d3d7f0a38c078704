#include "scheduling/workers/solve_costs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "solver/equilibrium/linear_body.hpp"

namespace forefeel {

SolveCosts::SolveCosts(std::function<StateSolver()> solver, const ReferenceOptions& options,
                       const std::string& name)
    : solver_(std::move(solver)), spacing_(options.spacing), box_(options.box) {
  if (name.empty()) return;
  file_ = options.cache_folder / (name + ".costs.csv");
  rest_file_ = options.cache_folder / (name + ".rest-cost.csv");
}

// The lock is held while measuring, so that concurrent callers get the same list.
RecordedCosts SolveCosts::recorded() {
  const std::lock_guard lock(mutex_);
  if (!costs_.solves.empty()) return costs_;
  costs_.solves = kept(file_, &SolveCosts::measured);
  std::vector<double> rest = kept(rest_file_, &SolveCosts::measured_at_rest);
  std::ranges::sort(rest);
  costs_.rest = rest.empty() ? 1e-9 : rest[rest.size() / 2];
  return costs_;
}

std::vector<double> SolveCosts::measured() const {
  constexpr std::uint64_t samples = 48;
  StateSolver solver = solver_();
  std::vector<double> seconds;
  for (std::uint64_t i = 0; i < samples; ++i) {
    const Vec3 share(random::uniform(random::mix(11, 3 * i)), random::uniform(random::mix(11, 3 * i + 1)),
                     random::uniform(random::mix(11, 3 * i + 2)));
    const Vec3 x = box_.low + share.cwiseProduct(box_.size());
    const double length = std::max(x.norm(), 1e-12);
    const Vec3 parent = x * std::max(0.0, 1 - spacing_ / length);  // a spacing nearer to rest
    const SolveOutcome start = solver.reference(parent);
    const auto before = std::chrono::steady_clock::now();
    const SolveOutcome outcome = solver.from(start.equilibrium.get(), x, {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    if (outcome.state.usable()) seconds.push_back(std::max(took.count(), 1e-9));
  }
  return seconds;
}

// Measured between solves at other positions, as in a session. The first solve is not counted: it includes
// the symbolic factorisation.
std::vector<double> SolveCosts::measured_at_rest() const {
  constexpr int samples = 15;
  StateSolver solver = solver_();
  std::vector<double> seconds;
  for (int i = 0; i < samples; ++i) {
    solver.from(nullptr, spacing_ * Vec3::Unit(i % 3), {});
    const auto before = std::chrono::steady_clock::now();
    const SolveOutcome outcome = solver.from(nullptr, Vec3::Zero(), {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    if (outcome.state.usable()) seconds.push_back(std::max(took.count(), 1e-9));
  }
  return seconds;
}

std::vector<double> SolveCosts::kept(const std::filesystem::path& file,
                                     std::vector<double> (SolveCosts::*measure)() const) {
  constexpr std::string_view columns[] = {"seconds"};
  if (!file.empty() && std::filesystem::exists(file)) try {
      if (std::vector<double> values = read_csv(file, columns).values; !values.empty()) return values;
    } catch (const InputError&) {  // damaged: measured again
    }
  std::vector<double> seconds = (this->*measure)();
  if (file.empty() || seconds.empty()) return seconds;
  try {
    std::filesystem::create_directories(file.parent_path());
    std::string table = "seconds\n";
    for (const double s : seconds) table += fmt::format("{}\n", s);
    write_whole(file, table);
  } catch (const std::exception& problem) {
    note_ = fmt::format("recorded costs are not kept: {}", problem.what());
  }
  return seconds;
}

}  // namespace forefeel
