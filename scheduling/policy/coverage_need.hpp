#pragma once
// What the labels say is lacking where the hand will be, and what one more state would mend.
//
// A place q lacks, at three spacings H = 4 h, 2 h, h,
//   n_H(q) = N_H lack(label of q at spacing H)                    lack: blank > gap > sparse > safe
// where the label at H is that of coverage.hpp with H for h: as scale-free as labels are. N_H, how much a lack at H
// counts, is learnt from the states that come: the share of those in the blank or a gap at H, but not at 2 H, whose
// force the model had missed by more than the JND (with a prior of a few states). A smooth body soon asks for coarse
// spacings alone, a harder one for fine ones. A state
// at c mends the places within its reach 2 H of them, a little beyond where it makes a place sparse:
//   V(c) = sum_q w(q) sum_H n_H(q) m_H(q, c) prod_p (1 - m_H(q, p)),    m_H(q, c) = (1 - |q - c|^2 / (2 H)^2)_+
// over the states p that are being solved. w(q) is how soon the hand may be at q. The places are points of the path
// ahead, as predicted or as known, folded into the box where it leaves it, and one in each cube of 2 h of the box, which
// take over what an uncertain prediction does not say.
// A model that interpolates in lattice cells needs more than labels tell: to each corner of a cell that the path ahead
// crosses, w over the number of corners that the cell still lacks is added.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "scheduling/policy/need_left.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

struct NeedOptions {
  double path_share = 0.75;  // of the weight: on the path ahead; the rest on the box
  bool shuffle = false;      // labels permuted among all places: the placebo
  std::uint64_t seed = 0;    // of the permutation
};

class CoverageNeed {
 public:
  static constexpr int scales = 3;
  explicit CoverageNeed(NeedOptions options);
  ~CoverageNeed();

  // Once a planning step: labels of all places now, and w, and the states that are being solved.
  void look(const PlannerView& view);
  void pend(std::span<const Vec3> pending);  // others are being solved than when it looked
  // V of each candidate given the states that are being solved; never negative.
  void worth(std::span<const Candidate> candidates, std::span<double> out) const;

 private:
  struct Place {
    Vec3 at;
    double weight = 0;
    std::array<Label, scales> label{Label::blank, Label::blank, Label::blank};
    std::array<Vec3, scales> axis{Vec3::Zero(), Vec3::Zero(),
                                  Vec3::Zero()};  // of an empty cone where it is blank
    std::array<bool, scales> due{};               // to be labelled anew
  };
  void begin(const StateSpace& space);
  void learn(const StateSpace& space, std::span<const float> surprises);
  void teach(const Vec3& at, double surprise);
  void relabel(Place& place, std::size_t scale) const;
  void weigh_scales(bool with_stiffness);
  void weigh(const PlannerView& view);
  static double urgency(double t, double solve);
  void shuffle_labels();
  void gather_needs();
  void gather_corners(const PlannerView& view);

  NeedOptions options_;
  const StateSpace* space_ = nullptr;
  struct Index;
  std::unique_ptr<Index> index_;                  // one triangulation of the states for the three spacings
  std::array<double, scales> importance_{};       // N_H
  std::array<double, scales> missed_{}, seen_{};  // states that came into a lack at H, and the model's misses
  std::size_t known_ = 0;
  std::vector<Place> box_;                        // fixed; labels kept up to date
  std::vector<Place> places_;                     // of this step: the path ahead, then the box
  std::vector<std::pair<Vec3, double>> corners_;  // unknown ones of the cells ahead, and what each adds
  NeedLeft left_;                                 // of those that need anything
};

}  // namespace forefeel
