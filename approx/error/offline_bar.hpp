#pragma once
// Error bars of a model f~, made offline from known states: half-widths e_p(x) [N] such that |f~(x) - f(x)| <= e_p(x)
// at the share p of the places, for each p of bar_levels. Method: split conformal prediction, normalised (Papadopoulos
// et al. 2002) and separate for each label (Vovk et al., Algorithmic Learning in a Random World, 2005, ch. 4):
//   e_p(x) = q_p (s(x) + b),   q_p: the ceil((n + 1) p)-th least of n scores |f~_i - f_i| / (s(x_i) + b)
// The scores are those of known forces f_i that are held out in groups of neighbouring positions (left_out.hpp).
// Held-out positions are as far from known states as the wanted places. s [N]: scale of the error
// (approx/error/error_scale.hpp), from the 16 states nearest to x. b [N]: the part of the error that does not shrink
// near a state, such as noise. b is 0, 0.1, 0.3, 1 or 3 times the median error, whichever gives the 95 % bars the
// least interval score (Gneiting, Raftery 2007, Eq. 43).
// Measured states (without stiffness), if the model was chosen, are judged by a Gaussian process of them
// (measured/force_field.hpp), which knows the noise sigma of their forces and how far the force may be from its own:
//   s(x)^2 = deviation(x)^2 + |f~(x) - process|^2,   e_p(x) = q_p sqrt(v(x)) + m_p S E
// The held-out forces f_i tell whether s is too small. They are measured, and their errors are alike within a group, so
//   y_i^2 = (|f~_i - f_i| - m S E)^2 / v_i,   v_i = s(x_i)^2 + 3 sigma^2,   w_i = s(x_i)^2 / v_i
//   K = n mean(w),   g^2 = max(1, (nu + n mean(w y^2)) / (nu + K))
// n: number of groups. w: what a comparison tells of s; nothing where noise is most of it. The process's own deviation
// counts as nu = 6 groups. Its law was found from n groups, so s is known with few degrees of freedom: the quantiles of
// sqrt(F(3, n + 1)) (Student's t of three components; at 95 % 1.61 for many groups, 2.57 for three). Errors may have
// heavier or lighter tails. So q_p is the mean of that quantile, weighted by nu, and of the ceil((n + 1) p) / n
// quantile of y_i with v of below, weighted by K; without it for fewer than p / (1 - p) groups.
// Wanted places are often nearer to the states than held-out ones. By a smooth law the error then falls with a high
// power of the distance, which nothing measured has shown. It is believed to fall with the square. With rms s and
// median distance d of the held-out positions (h) and of the wanted places (w) inside the states, g^2 is at least
//   (nu + n mean(w y^2)) / (nu + K) r^(2 n / (n + nu)),   r = max(1, (s_h / s_w) / max(1, d_h / d_w)^2)
// The law is one for all places, but a force may be rough in some of them (a kink of a stiff wall in a smooth field).
// The process then takes the roughness for noise. Noise is the same everywhere, misfit is not, so with L(x) the mean of
// y^2 over the 30 held-out positions nearest to x, over the mean of all:
//   t(x)^2 = 1 + B (L(x) - 1),   B = max(0, 1 - var_0 / var(L)),   var_0 = 2 / (3 max(1, groups among the 30))
//   v(x)   = max(max(1, g^2 t^2) s^2,   mean(y^2) (t^2 (s^2 + 3 sigma^2) - c 3 sigma^2))
// B shrinks L as far as its differences are those of chance (James and Stein 1961); var_0 is the variance of L if all
// errors were normal with one deviation. c: 10 % quantile of t^2 over the held-out positions; there all misses are
// noise.
// A bar is never narrower than by the process's own deviation: held-out forces lie on the lines and levels of the
// states, where the force is known better than between them. The bar is that of the force itself,
// without the noise of a measurement; the bars of samples hold it, because their forces do. S E: least error across the
// states; m_p = 2, 3, 4 is a prior: the stiffness across is seldom more than so many times the largest one along them.
// If the caller gives check solves (at random places of the box, not used as states), their errors are the scores, and
//   s(x) = max(|f~(x)|, f0), f0 = 0.05 N,   b = 0,
//   q_p: the ceil(n p)-th least of all n scores |f~_i - f_i| / max(|f~_i|, f0)
// A set that was placed to hold an error E at 95 % of the box (scheduling/placement) then has 95 % bars no wider than E
// anywhere in the box. Scores inside the states and outside them (left_out.hpp) are kept apart, because extrapolation
// is worse than interpolation at the same distance. A label with fewer than 30 scores, or with too few for a level,
// uses the scores of all labels. A level p needs p / (1 - p) scores: 99 for the level 99 %. If all labels together have
// fewer, the bar is infinite. If there are too few scores outside, those of all places are used, and the bar is at
// least as wide as the largest score outside demands.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "approx/error/conformal_factors.hpp"
#include "approx/error/left_out.hpp"
#include "approx/measured/force_field.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

using BarWidths = std::array<double, bar_levels.size()>;  // [N], of each level

// One held-out force, and how well the others predict it.
struct BarSample {
  Vec3 at = Vec3::Zero();           // [m]
  double force = 0, predicted = 0;  // |f|, |f~| [N]
  Label label = Label::blank;       // of its position, with its part held out
  double spread = unknown;      // of its position, with its part held out [m]; infinite: not between states
  SeenPlace seen = {};          // from the remaining states
  double scale = 0, error = 0;  // s, |f~ - f| [N]
  double across = 0;            // least error across the states, of measured ones [N]
  std::uint32_t part = 0;       // forces of one part are held out together
  BarWidths bar{};              // from the scores of the other parts
};

// How well bars from the other parts cover the samples.
struct BarCover {
  std::size_t samples = 0;
  std::array<double, bar_levels.size()> inside{unknown, unknown,
                                               unknown};  // share inside of those with a bar [1]; NaN: none
  double width_p50 = unknown;                             // median half-width of 95 % [N]
};

struct OfflineBarOptions;

class OfflineBars {
 public:
  OfflineBars() = default;  // without samples: all bars are infinite
  explicit OfflineBars(std::vector<BarSample> samples);
  // Of measured forces; noise: sigma of a component [N]; groups: independent ones, held out in turn; shrinkage: r.
  OfflineBars(std::vector<BarSample> samples, double noise, std::size_t groups, double shrinkage = 1);

  BarWidths at(Label label, bool outside, double scale) const;  // outside: of the states; scale: s(x) [N]
  // Of measured states: the bar at x, across: least error across the states [N].
  BarWidths at(const Vec3& x, double scale, double across) const;
  double constant() const { return constant_; }  // b [N]
  bool checked() const { return checked_; }      // from check solves
  std::span<const BarSample> samples() const { return samples_; }
  BarCover cover(std::optional<Label> label = {}) const;  // of all, or of one label
  BarCover cover_outside() const;                         // of those outside the others

 private:
  friend OfflineBars checked_bars(const StateSpace& known, std::span<const State> checks,
                                  const OfflineBarOptions& options);
  // What judged bars are made of.
  struct Judge {
    double trust = 1, noise = 0;  // g at the wanted places; 3 sigma^2 [N^2]
    double mean = 0, calm = 0;    // of y^2: its mean, and that times c
    double locality = 0;          // B
    std::vector<double> misses;   // y_i^2
    BarWidths quantiles{};        // q_p
  };
  void find_locality(double each);
  double local(const Vec3& x, std::optional<std::uint32_t> but) const;  // t^2, without one part
  double variance(double scale, double trust, double local) const;      // v [N^2]

  std::vector<BarSample> samples_;
  bool checked_ = false;
  double constant_ = 0;
  Judge judge_;
  std::array<ByLabel<BarWidths>, 2> factors_{};  // inside and outside
};

// How the wanted places are evaluated, and where they lie.
struct OfflineBarOptions {
  ModelOptions model = {};
  bool all = false;                        // one model of all states
  std::optional<FieldOptions> field = {};  // the process in place of the model
  std::optional<FieldOptions> judge = {};  // of measured states: s and sigma from the process
  double spacing = 0.006;                  // h [m]
  std::span<const SeenPlace> wanted = {};  // where the bars are wanted; empty: not known
  std::span<const double> scales = {};     // s(x) of each [N], with a judge; empty: not known
};

// states: usable ones, one at each position. Fewer than 8 states or 3 groups give no samples.
OfflineBars measure_bars(std::span<const State> states, const OfflineBarOptions& options);

// The same from check solves; fewer than 20 give no samples.
OfflineBars checked_bars(const StateSpace& known, std::span<const State> checks,
                         const OfflineBarOptions& options);
// Judged bars of places that are asked together: none is narrower than the widest of those that count over `times`. A
// process may be far surer at its rows than between them, but not that much: its law is a guess.
void keep_together(std::span<BarWidths> bars, std::span<const char> counts, double times);
inline constexpr double across_of_95 = 3;  // m_p of 95 %
// Adds the least error across the states [N] to a bar, times m_p.
void widen(BarWidths& widths, double across);
// s(x) [N] of a model with the force f~(x), as judged by the process: its deviation, and how far the model is from it.
double judged_scale(const ForceField::Prediction& judged, const Vec3& force);
double checked_scale(const Vec3& force);  // s(x) [N]

// s(x) [N] of a model with the force f~(x) [N], from the states of a space nearest to x.
double scale_at(const StateSpace& space, const Vec3& x, const Vec3& force);

}  // namespace forefeel
