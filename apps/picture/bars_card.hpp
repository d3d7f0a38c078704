#pragma once
// The card of a report about error bars: how many samples lie inside, for each level and label.

#include <string>

#include "scheduling/record/summary.hpp"

namespace forefeel {

// How a card is coloured.
enum class Judged { plain, good, warn, bad };

struct Card {
  std::string value, what;
  Judged judged = Judged::plain;
};

// Bad where a level falls short by more than 5 points, of all samples (20 at least) or of a label with 100; a
// warning by more than 2.
Card bars_card(const SessionSummary::ErrorBars& bars);

}  // namespace forefeel
