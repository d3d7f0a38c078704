#pragma once
// Estimates from the coverage labels how much states are needed where the hand will be, and how much of that need one
// more state would remove.
//
// A place q has a need at each of three spacings H = 4 h, 2 h, h:
//   n_H(q) = w(q) N_H lack(label of q at spacing H)               lack: blank > gap > sparse > safe
// The label at H is that of coverage.hpp with H in place of h. The weight w(q) is larger the sooner the hand may be at
// q. N_H, the importance of spacing H, is learnt during the session, from the states solved at places that were blank
// or a gap at H, but not at 2 H. N_H is the share of these states whose force the model had missed by more than the JND
// (just noticeable difference); a prior counts as a few states. A smooth body soon needs coarse spacings only; a
// strongly nonlinear one also needs fine ones.
//
// A state at c reduces the need of the places within 2 H. This is slightly more than the distance at which it makes a
// place sparse. The worth of the state is
//   V(c) = sum_q sum_H n_H(q) m_H(q, c) prod_p (1 - m_H(q, p)),    m_H(q, c) = (1 - |q - c|^2 / (2 H)^2)_+
// where p runs over the states being solved.
//
// There are two kinds of places q: points of the path ahead, predicted or known, mirrored into the box where they are
// outside; and the centres of cubes of side 2 h that fill the box. The less certain the prediction, the more weight
// goes from the path to the box.
//
// With regions, labels at points give way to volumes: the need of a cube is the mean over its volume of the lack at
// each voxel (region_shares.hpp), and a point of the path has the label of its voxel.
//
// A model that interpolates in lattice cells needs all corners of a cell, which labels do not express. For
// it, each unknown corner of a cell on the path ahead gains w / (number of unknown corners of that cell).

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "scheduling/policy/kept_label.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/policy/region_shares.hpp"

namespace forefeel {

struct NeedOptions {
  double path_share = 0.75;  // share of the weight on the path ahead; the box has the rest
  bool shuffle = false;      // the placebo: labels are permuted among all places
  bool regions = false;      // volumes instead of labels at points
  std::uint64_t seed = 0;    // of the permutation
};

class CoverageNeed {
 public:
  static constexpr int scales = 3;
  explicit CoverageNeed(NeedOptions options);

  // Call once per planning step. Reads new states, labels all places, sets w and the states being solved.
  void look(const PlannerView& view);
  void pend(std::span<const Vec3> pending);  // replaces the states being solved, between two look() [m]
  // V of each candidate; never negative. out: #candidates.
  void worth(std::span<const Candidate> candidates, std::span<double> out) const;

 private:
  struct Place {
    Vec3 at;
    double weight = 0;
    std::array<KeptLabel, scales> kept{};
    std::array<bool, scales> due{};  // the label may have changed
  };
  void begin(const StateSpace& space);
  void learn(std::span<const float> surprises);
  void teach(const Vec3& at, double surprise);
  double lack_of(std::size_t place, std::size_t scale) const;
  void weigh_scales(bool with_stiffness);
  void weigh(const PlannerView& view);
  void shuffle_labels();
  void gather_needs();
  void gather_corners(const PlannerView& view);

  NeedOptions options_;
  const StateSpace* space_ = nullptr;
  std::vector<Thresholds> limits_;                // by scale; the space's triangulation serves all of them
  std::array<double, scales> importance_{};       // N_H
  std::array<double, scales> missed_{}, seen_{};  // states solved in a blank or gap at H: misses, all
  std::size_t known_ = 0;
  std::vector<Place> box_;                        // fixed; labels kept up to date
  std::vector<RegionShares> regions_;             // by scale, of the cubes of box_; empty: not used
  std::vector<Place> places_;                     // of this step: the path ahead, then the box
  std::vector<std::pair<Vec3, double>> corners_;  // unknown corners of the cells ahead, and what each adds
  NeedLeft left_;                                 // of the places with a need
};

}  // namespace forefeel
