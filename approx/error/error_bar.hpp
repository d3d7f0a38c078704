#pragma once
// Error bars of a force f~ [N]: half-widths e_p(x) [N] such that |f~(x) - f(x)| <= e_p(x) at the share p of the places,
// for each level p of bar_levels. Method: split conformal prediction, normalised by a scale (Papadopoulos et al. 2002)
// and separate for each label (Vovk et al., Algorithmic Learning in a Random World, 2005, ch. 4):
//   e_p(x) = q_p (s(x) + b)
//   s(x)  scale of the error [N], known before the truth: from the states nearest to x (error_scale.hpp), a model's own
//         estimate, or the deviation of a process of measured forces (measured/force_field.hpp)
//   q_p   factor of the label [1]: the p-quantile of scores |f~_i - f_i| / (s(x_i) + b) at places whose truth is known
//   b     the part of the error that does not shrink near a state, such as noise [N]
// The scores are those of whatever there is:
//   a prior            scores of other sessions: grasp_prior() by label; of touches, in touch_bar_factors()
//   audited solves     of a session, as they come: ConformalFactors, touch_bar_factors()
//   held-out groups    of known states without a session: measure_bars(). They are as far from the rest as the wanted
//                      places are from the states (left_out.hpp)
//   check solves       solves that are not used as states: checked_bars()
//
//   const OfflineBars bars = measure_bars(states, {.model = model, .wanted = wanted});
//   const auto [at_90, at_95, at_99] = bars.at({.label = label, .scale = scale_at(space, x, force)});   // [N]
//
// A level p needs p / (1 - p) scores: 99 for the level 99 %. With fewer the bar is infinite. Bars of measured forces
// (states without stiffness whose model was chosen) also tell how far the law of the process is off (judged_bar.cpp).

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "approx/error/left_out.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/common/tolerance.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

inline constexpr std::array bar_levels{0.90, 0.95, 0.99};
using BarWidths = std::array<double, bar_levels.size()>;   // [N], of each level
using BarFactors = std::array<double, bar_levels.size()>;  // q of each level

inline BarFactors unknown_factors() {  // infinite
  BarFactors factors{};
  factors.fill(std::numeric_limits<double>::infinity());
  return factors;
}

// Quantiles of the scores of one label, at these shares; the last one is the largest score.
inline constexpr std::array prior_shares{0.05, 0.25, 0.5,  0.7,   0.8,  0.85,  0.9,  0.925,
                                         0.95, 0.96, 0.97, 0.975, 0.98, 0.985, 0.99, 1.0};
using PriorScores = std::array<double, prior_shares.size()>;
std::array<PriorScores, 4> grasp_prior();  // of sessions with a grasped patch, in the order of Label

struct ConformalOptions {
  double gamma = 0.01;                                   // step of a_t for a score of weight 1
  std::size_t window = 300;                              // scores kept, of each label
  double prior_weight = 100;                             // in scores
  std::optional<std::array<PriorScores, 4>> prior = {};  // by label
};

// Factors of a session by adaptive conformal inference (Gibbs, Candes 2021): q is the (1 - a_t)-quantile of the last
// scores of the label, and after each score
//   a_{t+1} = a_t + gamma (a - err_t),   err_t = 1 where the score exceeds q, else 0,   a = 1 - p
// In the long run the share a of the scores then lies outside the bar, however their distribution changes. The prior
// is always kept. Without a prior the factors of a label are infinite until its first score. If a_t falls to 0, q is
// twice the largest score. One thread per object.
class ConformalFactors {
 public:
  explicit ConformalFactors(ConformalOptions options = {});

  const BarFactors& factors(Label label) const { return of(label).factors; }
  // weight, in (0, 1]: how much this score counts; 1 for a score at a place where the hand was. Scores that are
  // not finite are ignored.
  void learn(Label label, double score, double weight = 1);

 private:
  struct Score {
    double value = 0, weight = 1;
  };
  struct Track {
    std::deque<Score> scores;
    BarFactors miss{};  // a_t
    BarFactors factors = unknown_factors();
  };
  static std::size_t index(Label label) { return static_cast<std::size_t>(label); }
  const Track& of(Label label) const { return tracks_[index(label)]; }
  void update(Label label);

  ConformalOptions options_;
  std::array<Track, 4> tracks_;
};

// Factors of a session that touches a body anywhere, from its scores so far and those of other such sessions.
BarFactors touch_bar_factors(const std::vector<double>& scores);

// One held-out force, and how well the others predict it.
struct BarSample {
  Vec3 at = Vec3::Zero();           // [m]
  double force = 0, predicted = 0;  // |f|, |f~| [N]
  Label label = Label::blank;       // of its position, with its part held out
  double spread = unknown;          // likewise [m]; infinite: not between states
  SeenPlace seen = {};              // from the remaining states
  double scale = 0, error = 0;      // s, |f~ - f| [N]
  double across = 0;                // least error across the states, of measured ones [N]
  std::uint32_t part = 0;           // forces of one part are held out together
  BarWidths bar{};                  // from the scores of the other parts
};

// How well bars from the other parts cover the samples.
struct BarCover {
  std::size_t samples = 0;
  BarFactors inside{unknown, unknown, unknown};  // share inside, of those with a bar [1]; NaN: none
  double width_p50 = unknown;                    // median half-width of 95 % [N]
};

// A place where a bar is wanted. across: least error across the states, of measured ones [N].
struct BarPlace {
  Vec3 x = Vec3::Zero();       // [m]; used by judged bars only
  Label label = Label::blank;  // not used by judged bars
  bool outside = false;        // of the states
  double scale = 0;            // s(x) [N]
  double across = 0;
};

// A process of measured forces that judges them.
struct JudgedBy {
  double noise = 0;        // sigma of a component [N]
  std::size_t groups = 0;  // independent ones, held out in turn
};

struct OfflineBarOptions;

// Bars from held-out forces or from check solves.
class OfflineBars {
 public:
  OfflineBars() = default;  // without samples: all bars are infinite
  explicit OfflineBars(std::vector<BarSample> samples);
  OfflineBars(std::vector<BarSample> samples, const JudgedBy& by);  // of measured forces

  BarWidths at(const BarPlace& place) const;
  double constant() const { return constant_; }  // b [N]
  bool checked() const { return checked_; }      // from check solves
  std::span<const BarSample> samples() const { return samples_; }
  BarCover cover(std::optional<Label> label = {}) const;  // of all, or of one label
  BarCover cover_outside() const;                         // of those outside the others

 private:
  friend OfflineBars checked_bars(const StateSpace&, std::span<const State>, const OfflineBarOptions&);
  // What judged bars are made of.
  struct Judge {
    double trust = 1, noise = 0;  // g at the wanted places; 3 sigma^2 [N^2]
    double mean = 0, calm = 0;    // of y^2: its mean, and that times c
    double locality = 0;          // B
    std::vector<double> misses;   // y_i^2
    BarFactors quantiles{};       // q_p
  };
  void find_locality(double each);
  double local(const Vec3& x, std::optional<std::uint32_t> but) const;  // t^2, without one part
  double variance(double scale, double trust, double local) const;      // v [N^2]
  double deviation(const BarPlace& place) const;                        // sqrt(v) [N]

  std::vector<BarSample> samples_;
  bool checked_ = false;
  double constant_ = 0;
  bool judged_ = false;  // by a process of measured forces
  Judge judge_;
  std::array<ByLabel<BarFactors>, 2> factors_{};  // inside and outside
};

// How the wanted places are evaluated, and where they lie.
struct OfflineBarOptions {
  ModelOptions model = {};
  bool all = false;                        // one model of all states
  std::optional<FieldOptions> field = {};  // the process in place of the model
  std::optional<FieldOptions> judge = {};  // of measured states: s and sigma from the process
  double spacing = 0.006;                  // h [m]
  std::span<const SeenPlace> wanted = {};  // where the bars are wanted; empty: not known
  std::function<void(double)> show = {};   // called by one thread with the share done
};

// states: usable ones, one at each position. Fewer than 8 states or 3 groups give no samples.
OfflineBars measure_bars(std::span<const State> states, const OfflineBarOptions& options);

// From check solves at random places of the box; fewer than 20 give no samples. s(x) = max(|f~(x)|, 0.05 N), b = 0, and
// all labels have one factor: a set that was placed to hold an error E at 95 % of the box (scheduling/placement) then
// has 95 % bars no wider than E anywhere in the box.
OfflineBars checked_bars(const StateSpace& known, std::span<const State> checks,
                         const OfflineBarOptions& options);
double checked_scale(const Vec3& force);  // s(x) [N]

// s(x) [N] of a model with the force f~(x) [N], from the 16 states of a space nearest to x.
double scale_at(const StateSpace& space, const Vec3& x, const Vec3& force);

// Judged bars of places that are asked together: none is narrower than the widest of those that count over `times`. A
// process may be far surer at its rows than between them, but not that much: its law is a guess.
void keep_together(std::span<BarWidths> bars, std::span<const char> counts, double times);
// Adds the least error across the states [N] to a bar, times m_p = 2, 3, 4, a prior: the stiffness across is seldom
// more than so many times the largest one along them.
void widen(BarWidths& widths, double across);
inline constexpr double across_of_95 = 3;  // m_p of 95 %

// Held-out forces whose 95 % bar is no larger than a tolerance are called known within it. Their number, and that of
// the forces that truly were within it.
struct KnownWithin {
  std::size_t samples = 0, called = 0, true_ones = 0;
};
KnownWithin known_within(std::span<const BarSample> samples, const Tolerance& tolerance);

// The largest spacing h for which |f~ - f| is within the tolerance for at least 95 % of the held-out forces that would
// be safe at h, at least 20 of them. Safe: spread at most safe_spread h (geometry/coverage/coverage.hpp).
struct SpacingAdvice {
  double spacing = unknown;          // h [m]; NaN: no spacing suffices
  std::size_t safe = 0, within = 0;  // held-out forces that are safe at h; of these within the tolerance
  std::size_t wider = 0, wider_within = 0;  // safe only at larger spacings up to 1.5 h; of these within
  bool all = false;  // all held-out forces are safe at h: a larger spacing might do as well
};
SpacingAdvice advise_spacing(std::span<const BarSample> samples, const Tolerance& tolerance,
                             double safe_spread);

}  // namespace forefeel
