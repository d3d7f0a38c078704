#pragma once
// classify --bars: how well the force is known. States are held out in groups (approx/error/left_out.hpp) to find the
// error bars of points, the share of the box where the force is known within a tolerance, and the spacing that the data
// suggest.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "approx/error/known_within.hpp"
#include "approx/methods/evaluate.hpp"
#include "apps/classify/classify.hpp"
#include "geometry/common/declared.hpp"

namespace forefeel {

// Forces and bars at the points, and at evenly spread places of the box.
struct ErrorKnown {
  Tolerance tolerance;
  std::optional<Evaluation> points;  // nullopt without points
  Evaluation box;
  std::size_t places = 0, places_within = 0;  // of the box: all, and those known within the tolerance
  KnownWithin left_out;
  SpacingAdvice advice;
};

// True if errors are to be found: --bars is given, or no spacing is known. Only states with forces have errors;
// InputError for --bars without any.
bool wants_errors(const ClassifyArguments& arguments, const Classified& set);
ErrorKnown error_known(const Globals& globals, const ClassifyArguments& arguments, const Classified& set,
                       const std::vector<Vec3>& points);

void describe_errors(nlohmann::ordered_json& document, const ClassifyArguments& arguments,
                     const ErrorKnown& found);
void tell_errors(const Globals& globals, const ClassifyArguments& arguments, const ErrorKnown& found);
// Cells of a point in coverage.csv: bars, and whether it is known within the tolerance (1 or 0).
std::string error_cells(const ErrorKnown& found, std::size_t point);
std::vector<Declared> declared_errors();  // of these cells
std::vector<Declared> declared_errors_json();

// The tolerance of --tolerance, else that of the scene file, else 7 %.
Tolerance tolerance_of(const Globals& globals, const ClassifyArguments& arguments);

}  // namespace forefeel
