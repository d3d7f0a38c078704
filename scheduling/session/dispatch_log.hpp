#pragma once
// The rows of dispatch.csv while a run goes on, and what the planner counts and notes of its results. One thread owns
// it.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/quantiles.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/render/model_keeper.hpp"

namespace forefeel {

class DispatchLog {
 public:
  // A state is given to a worker. started: when it is expected to begin, until the worker tells [s]. parent: row of the
  // state that its solve starts from; -1: rest or a known state. Returns its row.
  std::uint32_t begin(int worker, const Candidate& candidate, double priority, std::int64_t parent,
                      double now, double started);
  std::uint32_t arrive(const State& state, Label label, double now);  // known without a solve

  DispatchRecord& operator[](std::uint32_t row) { return rows_[row]; }
  const std::vector<DispatchRecord>& rows() const { return rows_; }

  void know(std::int64_t row) {
    row_of_.push_back(row);
  }  // the next state of the space; -1: known at the start

  StateCounts counts = {};
  struct Plans {
    std::size_t all = 0;      // planning steps with an idle worker
    std::size_t content = 0;  // of these, the policy found no candidate worth a solve
  };
  Plans plans = {};
  std::size_t jobs = 0;       // of the solved states
  std::size_t strays = 0;     // results of no running job
  std::size_t elsewhere = 0;  // results for another position than asked
  std::vector<std::string> notes = {};

  // Moves all into the result. models: the keeper of the rendered models.
  void finish(SessionResult& result, ModelMaker& models);

 private:
  std::vector<DispatchRecord> rows_;
  std::vector<std::int64_t> row_of_;  // by state id
};

// The times that solves took [s], and what the next one is expected to take. One thread owns them.

class SolveTimes {
 public:
  explicit SolveTimes(double expected) : expected_(std::max(expected, least)) {}

  void note(double seconds) {
    constexpr std::size_t newest = 31;
    all_.push_back(seconds);
    const auto first = all_.end() - static_cast<std::ptrdiff_t>(std::min(newest, all_.size()));
    expected_ = std::max(median(std::vector<double>(first, all_.end())), least);
  }
  double expected() const { return expected_; }  // median of the newest; before the first, as given
  std::vector<double> take() { return std::move(all_); }

 private:
  static constexpr double least = 1e-6;
  double expected_;
  std::vector<double> all_;
};

}  // namespace forefeel
