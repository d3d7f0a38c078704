#include "scheduling/session/dispatch_log.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace forefeel {

std::uint32_t DispatchLog::begin(int worker, const Candidate& candidate, double priority, std::int64_t parent,
                                 double now, double started) {
  DispatchRecord record{.id = static_cast<std::uint32_t>(rows_.size()),
                        .at = candidate.at,
                        .label = candidate.region,
                        .choice = {.priority = priority}};
  if (candidate.site.exists()) record.choice.site = candidate.site.at;
  record.requested = std::isfinite(candidate.requested) ? candidate.requested : now;
  record.started = started;
  record.status = DispatchStatus::running;
  record.worker = worker;
  record.parent = parent;
  rows_.push_back(record);
  return record.id;
}

std::uint32_t DispatchLog::arrive(const State& state, Label label, double now) {
  DispatchRecord record{.id = static_cast<std::uint32_t>(rows_.size()), .at = state.tip(), .label = label};
  record.choice.site = state.site;
  record.requested = record.finished = record.known = now;
  record.status = state.usable() ? DispatchStatus::arrived : DispatchStatus::failed;
  rows_.push_back(record);
  return record.id;
}

void DispatchLog::finish(SessionResult& result, ModelMaker& models) {
  const std::vector<double>& first_used = models.first_used();
  for (std::size_t id = 0; id < first_used.size(); ++id)
    if (row_of_[id] >= 0) rows_[static_cast<std::size_t>(row_of_[id])].first_used = first_used[id];
  for (DispatchRecord& record : rows_)
    if (record.status == DispatchStatus::running && std::isnan(record.started))
      record.status = DispatchStatus::waiting;
  result.dispatch = std::move(rows_);
  result.switches = models.take_switches();
  result.counts = counts;
  result.solver.jobs = jobs;
  result.notes.insert(result.notes.end(), notes.begin(), notes.end());
}

}  // namespace forefeel
