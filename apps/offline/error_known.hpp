#pragma once
// classify --bars: how well the force is known. States are held out in groups (approx/error/left_out.hpp) to find the
// error bars of points, the share of the box where the force is known within a tolerance, and the spacing that the data
// suggest.

#include <optional>
#include <vector>

#include "approx/error/error_bar.hpp"
#include "approx/methods/evaluate.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/offline/classify.hpp"

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

// What classify --json says of it; bars: with --bars.
struct ErrorShown {
  const ErrorKnown& found;
  bool bars;
};
const JsonKeys<ErrorShown>& error_keys();
void tell_errors(const Globals& globals, const ClassifyArguments& arguments, const ErrorKnown& found);
// Of a point: its bar, and whether its force is known within the tolerance.
BarWidths bar_of(const ErrorKnown& found, std::size_t point);
bool is_known(const ErrorKnown& found, std::size_t point);

// The tolerance of --tolerance, else that of the scene file, else 7 %.
Tolerance tolerance_of(const Globals& globals, const ClassifyArguments& arguments);

}  // namespace forefeel
