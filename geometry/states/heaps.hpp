#pragma once
// Heaps of measured rows: a dwell of a hand or robot puts hundreds of rows about one place. A law of the field,
// held-out groups and nearest neighbours would see little else.
//
// Rows within a hundredth of the extent of one another are a place. A place with more than ten rows for each row of the
// usual (median) place is a heap, and one row stands for it: the means of position and force. The error of that is of
// the second order in the size of the place.

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

struct JoinedHeaps {
  std::vector<State>
      states;  // in order; a mean stands where the first row of its heap stood, without stiffness
  std::size_t heaps = 0, rows = 0;  // rows: in the heaps
};
// rows: usable. Where there is no heap they stay as they are.
JoinedHeaps join_heaps(std::vector<State> rows);

// Rows for what is chosen by counting them, as the law of a field. A hand that trembles makes wider heaps, too wide for
// one mean. Of a place of 1, 2, 4, 8 and 16 % of the extent with more than ten rows for each row of the usual place of
// that size, as many rows stay as the usual one has, evenly drawn. In order. Ten places or fewer do not tell what is
// usual.
std::vector<State> thinned_heaps(std::span<const State> rows);

}  // namespace forefeel
