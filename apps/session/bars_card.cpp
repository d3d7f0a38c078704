#include "apps/session/bars_card.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "approx/error/error_bar.hpp"
#include "geometry/common/counted.hpp"
#include "scheduling/record/attention.hpp"

namespace forefeel {
namespace {

constexpr std::size_t enough_of_label = 100;
constexpr double warn_from = 0.02, bad_from = 0.05;

Judged judged(const SessionSummary::Bars& bars, std::size_t enough) {
  if (bars.samples < enough) return Judged::plain;
  double missing = 0;
  for (std::size_t level = 0; level < bar_levels.size(); ++level)
    missing = std::max(missing, bar_levels[level] - bars.inside[level]);
  return missing > bad_from + 1e-9 ? Judged::bad : missing > warn_from + 1e-9 ? Judged::warn : Judged::good;
}

// "91.0/95.3/99.1 % of 210"
std::string in_words(const SessionSummary::Bars& bars) {
  return fmt::format("{:.1f}/{:.1f}/{:.1f} % of {}", 100 * bars.inside[0], 100 * bars.inside[1],
                     100 * bars.inside[2], bars.samples);
}

}  // namespace

Card bars_card(const SessionSummary::ErrorBars& bars) {
  if (bars.all.samples == 0) return {"–", "no sample has an error bar"};
  Card card{.value = said_percent(bars.all.inside[1]),
            .what = fmt::format("of {} inside their error bars of 95 %", counted(bars.all.samples, "sample")),
            .judged = judged(bars.all, few_samples)};
  for (const Label label : all_labels) {
    const SessionSummary::Bars& own = bars.by_label[label];
    if (own.samples == 0) continue;
    const Judged of_label = judged(own, enough_of_label);
    if (of_label > Judged::good) card.what += fmt::format("; {} {}", name(label), in_words(own));
    card.judged = std::max(card.judged, of_label);
  }
  if (std::isfinite(bars.all.width_p50))
    card.what += fmt::format("; median half-width {:.3g} N", bars.all.width_p50);
  return card;
}

}  // namespace forefeel
