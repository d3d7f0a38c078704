#pragma once
// Measures what solves of a body cost, once, and keeps the times beside the cache of its reference solves.

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_cache.hpp"

namespace forefeel {

class StateSolver;

class SolveCosts {
 public:
  // name: of the body's files; empty: nothing is kept.
  SolveCosts(std::function<StateSolver()> solver, const ReferenceOptions& options, const std::string& name);

  // Times of a fixed sample of solves from a neighbour, and of the state at rest. Any thread.
  RecordedCosts recorded();
  const std::optional<std::string>& note() const { return note_; }  // why they are not kept

 private:
  std::vector<double> measured() const;
  std::vector<double> measured_at_rest() const;
  // The times in the file. If there is no file, measures them and writes it.
  std::vector<double> kept(const std::filesystem::path& file,
                           std::vector<double> (SolveCosts::*measure)() const);

  std::function<StateSolver()> solver_;
  double spacing_;  // [m]
  Box box_;
  std::filesystem::path file_, rest_file_;
  std::mutex mutex_;
  RecordedCosts costs_;
  std::optional<std::string> note_;
};

}  // namespace forefeel
