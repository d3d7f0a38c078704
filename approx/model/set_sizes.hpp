#pragma once
// Sizes of the neighbour sets of a model (neighbours.hpp).

#include <cstddef>

#include "approx/model/model_options.hpp"

namespace forefeel {

// Neighbour count for sets with weights. With fewer states, one state that enters or leaves would determine the slope
// of the force, however small its weight. (A single neighbour needs no weight.)
constexpr std::size_t weighted_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 16;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// Neighbour count for sets without weights. Without stiffness, fewer states hardly determine the polynomial;
// the force would then jump by more than the JND (just noticeable difference) where a safe region ends.
constexpr std::size_t nearest_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 1;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
// Additional neighbours between two sides of a gap; without them each side would have about half of n.
constexpr std::size_t bridging_neighbours(const ModelOptions& options) {
  const std::size_t n = weighted_neighbours(options);
  return options.select == Select::label && n > 1 ? (n < 32 ? n : 32) : 0;
}
constexpr std::size_t most_neighbours(const ModelOptions& options) {
  return weighted_neighbours(options) + weighted_neighbours(options) / 6 + bridging_neighbours(options);
}
// Number of auxiliary places around a set with weights. Their data are the affine fit of the set, with a small weight.
// So a polynomial term that a single new state determines also enters gradually. (With stiffness, a state alone
// determines the linear terms.)
constexpr std::size_t affine_places(const ModelOptions& options) {
  const bool determined = options.data == Data::force_and_stiffness && options.kernel == Kernel::cubic;
  return options.select == Select::label && !determined ? 10 : 0;
}

// Least number of neighbours that for_states() allows: smaller sets are made by other rules.
constexpr std::size_t uncapped_neighbours = 32;

}  // namespace forefeel
