#pragma once
// Half-widths of error bars by adaptive conformal inference (Gibbs, Candes 2021, the update below). A score is
//   z = error / s   [1],   s [N]: scale of the error, known before the truth (error_scale.hpp)
// The bar of level 1 - a is q s [N], with q the (1 - a_t)-quantile of the scores so far at the same label. After
// each score
//   a_{t+1} = a_t + gamma (a - err_t),   err_t = 1 where z > q, else 0
// In the long run the share a of the scores then lies outside the bar, however their distribution changes. Only the
// last `window` scores are kept. A prior (quantiles measured beforehand) counts as `prior_weight` scores and is always
// kept. Without a prior the factors of a label are infinite until its first score. If a_t falls to 0, q is twice the
// largest score. One thread per object.

#include <array>
#include <cstddef>
#include <deque>
#include <limits>
#include <optional>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

inline constexpr std::array bar_levels{0.90, 0.95, 0.99};

// Quantiles of the scores of one label, at these shares; the last one is the largest score.
inline constexpr std::array prior_shares{0.05, 0.25, 0.5,  0.7,   0.8,  0.85,  0.9,  0.925,
                                         0.95, 0.96, 0.97, 0.975, 0.98, 0.985, 0.99, 1.0};
using PriorScores = std::array<double, prior_shares.size()>;

struct ConformalOptions {
  double gamma = 0.01;                                   // step of a_t for a score of weight 1
  std::size_t window = 300;                              // scores kept, of each label
  double prior_weight = 100;                             // in scores
  std::optional<std::array<PriorScores, 4>> prior = {};  // by label
};

class ConformalFactors {
 public:
  using Factors = std::array<double, bar_levels.size()>;  // q of each level

  explicit ConformalFactors(ConformalOptions options = {});

  static Factors unknown_factors() {  // infinite
    Factors factors{};
    factors.fill(std::numeric_limits<double>::infinity());
    return factors;
  }

  const Factors& factors(Label label) const { return of(label).factors; }
  // weight, in (0, 1]: how much this score counts; 1 for a score at a place where the hand was. Scores that are
  // not finite are ignored.
  void learn(Label label, double score, double weight = 1);

 private:
  struct Score {
    double value = 0, weight = 1;
  };
  struct Track {
    std::deque<Score> scores;
    std::array<double, bar_levels.size()> miss{};  // a_t
    Factors factors = unknown_factors();
  };
  static std::size_t index(Label label) { return static_cast<std::size_t>(label); }
  const Track& of(Label label) const { return tracks_[index(label)]; }
  void update(Label label);

  ConformalOptions options_;
  std::array<Track, 4> tracks_;
};

}  // namespace forefeel
