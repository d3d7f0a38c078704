#pragma once
// The energy jets of the known states, and what is known of how far each can be trusted.
//
// The model is a blend of energies (approx/loops/jet_sums.hpp), so its force f = -dE/dx does no work over a closed
// path, and its stiffness is symmetric. The weight of a jet falls as its own estimate to the fourth power:
//   e^2 = |f4 - f3|^2 + 1/4 |f3 - f2|^2 + e_0^2,  e_0 = 1e-6 N    (order 4; f_p: the jet's force of order p)
//   e   = |f3 - f2| (order 3), |f2 - f1| (order 2), with e_0
// so at its own state a jet is exact to (e_0 / e of the others)^4. The estimate sees where the series ends. It does not
// see a fold or another branch. Therefore each jet has a trust t [m], beyond which its estimate grows with distance:
//   t = min(max(l, h / 2, 1.25 c), 0.8 s)
//   l  material limit of the jet (solver/jet/jet_maker.hpp);  h: spacing
//   s  least distance of a surprise: a state whose force is off the jet's by more than max(3 e, limit(f))
//   c  largest distance, below s, of a state within that
// Beyond t the estimate grows as e (1 + k (r^2 / t^2 - 1)^3)^(1/2), k = 1 or more, so that at s it is at least the
// error seen there. limit(f): geometry/common/tolerance.hpp. t depends on the set of states, not on their order.
//
// Sources: the jets, Koiter 1945 and Cochelin, Damil and Potier-Ferry 1994; see solver/jet/jet_maker.hpp.

#include <cstddef>
#include <span>
#include <vector>

#include "approx/loops/aligned.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/common/tolerance.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

class ModelDraft;

class JetSet {
 public:
  JetSet(const StateSpace& space, const ModelOptions& options);  // the space must outlive the set

  void learn();  // the states that were added to the space since the last call
  // No state has a jet that serves: beside a fold its series ends within a quarter of the spacing.
  bool empty() const { return ids_.empty(); }
  // The ids of the `most` jets of least estimate at x, the least first. Members of the last choice count 0.8 times. A
  // jet of another branch is left out: its energy differs from the first one's by more than both estimates explain,
  // and a blend of the two would push with the difference.
  void choose(const Vec3& x, std::vector<StateId>& out);
  void forget() { last_.clear(), lost_ = false; }
  // After choose(x): x lies outside the radius of every jet, so that other states' data say more (updater.hpp). True
  // from an estimate of half the force on, false again below a third of it.
  bool lost(const Vec3& x, StateId best);
  void write(std::span<const StateId> chosen,
             ModelDraft& draft) const;  // the model of these jets: copies of them

  struct Trust {
    double distance = 0;   // t [m]
    double confirmed = 0;  // c [m]; 0: no state confirms the jet
    double surprised = 0;  // s [m]; infinite: none
    double excess = 0;     // at s: the square of the error over e
  };
  Trust trust(StateId id) const;  // of a state with a jet

 private:
  void add(StateId id, const State& state, double radius);
  void judge(std::size_t jet, const State& other, const double* estimates);
  void confirm_again(std::size_t jet);
  void set_trust(std::size_t jet);
  double& value(std::size_t jet, std::size_t row);
  std::size_t place_of(StateId id) const;
  bool on_another_branch(StateId id, StateId best, const Vec3& x) const;

  const StateSpace& space_;
  std::size_t most_;
  bool lost_ = false;
  Tolerance tolerance_;
  double spacing_, largest_force_ = 0;  // the second: of the states
  std::size_t seen_ = 0;
  std::vector<StateId> ids_, last_;  // of the jets; of the last choice
  std::vector<Trust> trusts_;
  std::vector<double> limits_, squared_, energies_;  // the last two: at the place of the last choice
  AlignedArray blocks_;
};

}  // namespace forefeel
