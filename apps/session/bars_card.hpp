#pragma once
// The card about error bars in the report: the share of samples inside their bars, for each level and label.

#include <string>

#include "scheduling/record/summary.hpp"

namespace forefeel {

// Colour of a card.
enum class Judged { plain, good, warn, bad };

struct Card {
  std::string value, what;
  Judged judged = Judged::plain;
};

// Bad if the share inside is more than 5 points below a level, over all samples (at least 20) or over a label with at
// least 100; a warning from 2 points on.
// Labels are named where theirs are short.
Card bars_card(const SessionSummary::ErrorBars& bars);

}  // namespace forefeel
