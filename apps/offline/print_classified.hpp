#pragma once
// Prints the result of `forefeel classify` for one set of states, as one JSON document or in words.

#include "apps/offline/classify.hpp"
#include "apps/offline/error_known.hpp"
#include "apps/offline/hull_spacing.hpp"

namespace forefeel {

// One set of states with the labels of the asked positions.
struct ClassifiedPoints {
  const Classified& set;
  const std::vector<Vec3>& points;     // [m]
  const std::vector<Coverage>& found;  // one for each point
  const std::optional<Agreement>& agreement;
  const std::optional<ErrorKnown>& errors;
  const std::optional<HullSpacing>& hull;  // where the spacing is estimated, of states that fill a volume
  double seconds;                          // for reading, indexing and labelling [s]
};

void print_classified(const Globals& globals, const ClassifyArguments& arguments,
                      const ClassifiedPoints& result);

}  // namespace forefeel
