#include "approx/error/conformal_factors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace forefeel {
namespace {

// The smallest score at which the summed weight of all scores up to it reaches `share` of the total.
double weighted_quantile(const std::vector<std::pair<double, double>>& sorted, double total, double share) {
  if (share >= 1) return 2 * sorted.back().first;
  double sum = 0;
  for (const auto& [score, weight] : sorted) {
    sum += weight;
    if (sum >= share * total) return score;
  }
  return sorted.back().first;
}

}  // namespace

ConformalFactors::ConformalFactors(ConformalOptions options) : options_(options) {
  for (const Label label : {Label::safe, Label::sparse, Label::gap, Label::blank}) {
    for (std::size_t i = 0; i < bar_levels.size(); ++i) tracks_[index(label)].miss[i] = 1 - bar_levels[i];
    update(label);
  }
}

void ConformalFactors::learn(Label label, double score, double weight) {
  if (!std::isfinite(score)) return;
  Track& track = tracks_[index(label)];
  for (std::size_t i = 0; i < bar_levels.size(); ++i) {
    const double missed = score > track.factors[i] ? 1 : 0;
    const double next = track.miss[i] + weight * options_.gamma * (1 - bar_levels[i] - missed);
    track.miss[i] = std::clamp(next, -options_.gamma, 1.0);
  }
  if (track.scores.size() == options_.window) track.scores.pop_front();
  track.scores.push_back({score, weight});
  update(label);
}

void ConformalFactors::update(Label label) {
  Track& track = tracks_[index(label)];
  std::vector<std::pair<double, double>> sorted;
  double total = 0;
  const auto add = [&](double score, double weight) {
    sorted.emplace_back(score, weight);
    total += weight;
  };
  if (options_.prior) {
    double below = 0;
    for (std::size_t i = 0; i < prior_shares.size(); ++i) {
      add((*options_.prior)[index(label)][i], options_.prior_weight * (prior_shares[i] - below));
      below = prior_shares[i];
    }
  }
  for (const Score& score : track.scores) add(score.value, score.weight);
  if (sorted.empty()) return;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < bar_levels.size(); ++i) {
    track.factors[i] = weighted_quantile(sorted, total, 1 - track.miss[i]);
    // Levels stay in order: a wider one is never narrower.
    if (i > 0) track.factors[i] = std::max(track.factors[i], track.factors[i - 1]);
  }
}

}  // namespace forefeel
