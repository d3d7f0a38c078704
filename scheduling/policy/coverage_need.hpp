#pragma once
// What the labels say is lacking where the hand will be, and how much of it one more state would mend.
//
// A place q has a need at each of three spacings H = 4 h, 2 h, h:
//   n_H(q) = w(q) N_H lack(label of q at spacing H)               lack: blank > gap > sparse > safe
// The label at H is that of coverage.hpp with H for h; w(q) says how soon the hand may be at q.
// N_H, how much a lack at H counts, is learnt during the session. Of the states that came into a blank or gap at H, but
// not at 2 H, it is the share whose force the model had missed by more than the JND (with a prior that counts as a few
// states). A smooth body soon needs coarse spacings alone, a harder one needs fine ones.
//
// A state at c mends the places within its reach 2 H, a little farther than where it makes a place sparse. Its worth is
//   V(c) = sum_q sum_H n_H(q) m_H(q, c) prod_p (1 - m_H(q, p)),    m_H(q, c) = (1 - |q - c|^2 / (2 H)^2)_+
// with p over the states that are being solved.
//
// The places are points of the path ahead, predicted or known, folded into the box where it leaves the box; and the
// centres of cubes of 2 h that fill the box, which take the weight that an uncertain prediction does not give to the path.
//
// A model that interpolates in lattice cells needs more than labels tell. Each unknown corner of a cell that the path ahead
// crosses gets w / (unknown corners of that cell) in addition.

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
  double path_share = 0.75;  // of the weight that is on the path ahead; the rest is on the box
  bool shuffle = false;      // the placebo: labels are permuted among all places
  std::uint64_t seed = 0;    // of the permutation
};

class CoverageNeed {
 public:
  static constexpr int scales = 3;
  explicit CoverageNeed(NeedOptions options);
  ~CoverageNeed();

  // Once a planning step: takes in new states, labels all places, sets w and the states that are being solved.
  void look(const PlannerView& view);
  void pend(std::span<const Vec3> pending);  // other states are being solved than at look() [m]
  // V of each candidate; never negative. out: #candidates.
  void worth(std::span<const Candidate> candidates, std::span<double> out) const;

 private:
  struct Place {
    Vec3 at;
    double weight = 0;
    std::array<Label, scales> label{Label::blank, Label::blank, Label::blank};
    // Of an empty cone, which proves that the place is blank; zero: unknown.
    std::array<Vec3, scales> axis{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    std::array<bool, scales> due{};  // the label may have changed
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
  std::unique_ptr<Index> index_;                  // one triangulation of the states serves the three spacings
  std::array<double, scales> importance_{};       // N_H
  std::array<double, scales> missed_{}, seen_{};  // of states that came into a lack at H: misses, all
  std::size_t known_ = 0;
  std::vector<Place> box_;                        // fixed; labels kept up to date
  std::vector<Place> places_;                     // of this step: the path ahead, then the box
  std::vector<std::pair<Vec3, double>> corners_;  // unknown corners of the cells ahead, and what each adds
  NeedLeft left_;                                 // of the places with a need
};

}  // namespace forefeel
