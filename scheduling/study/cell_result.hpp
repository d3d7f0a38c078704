#pragma once
// The result of one cell of a study: named values in a fixed order, one row of cells.csv.

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/record/summary_columns.hpp"

namespace forefeel {

struct SessionInput;

class StudyCellResult {
 public:
  StudyCellResult() = default;
  explicit StudyCellResult(std::vector<Column> columns) : columns_(std::move(columns)) {}

  const std::vector<Column>& columns() const { return columns_; }
  bool empty() const { return columns_.empty(); }
  const ColumnValue* find(std::string_view name) const;  // null if there is none
  // NaN if there is no such column or it holds no number.
  double number(std::string_view name) const;
  // An existing column keeps its position; a new one is appended.
  void set(std::string_view name, ColumnValue value);
  // The notes of the cell's session: violations of contracts by its parts, failed solves …
  const std::vector<std::string>& notes() const { return notes_; }
  void set_notes(std::vector<std::string> notes) { notes_ = std::move(notes); }

 private:
  std::vector<Column> columns_;
  std::vector<std::string> notes_;
};

// The result of one session: the columns of its summary, and those that a study adds (cells_output()).
// Values that depend on wall time are left empty, so a cell always has the same result.
StudyCellResult cell_result(const SessionResult& result, const SessionInput& input,
                            const SessionOptions& options);

// Adds how good the session's own predictor was, by horizon: prediction.ms20.p95, …within_50, …within_90.
void add_prediction(const std::vector<PredictionError>& errors, StudyCellResult& row);

// The notes of all cells, one line for each kind (record/notes.hpp).
std::vector<std::string> notes_of(std::span<const StudyCellResult> cells);

// For `forefeel help`: the columns of cells.csv behind the varied keys and the seed.
DeclaredTable cells_output();

// Share of first visits within the tolerance of the reference force, |F - f| <= max(tolerance |f|, F_abs).
double first_visits_within(const SessionResult& result, const SwitchOptions& jnd, double tolerance);

}  // namespace forefeel
