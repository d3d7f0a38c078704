#pragma once
// The neighbour set of a HIP: the states whose data the current model uses.
//   nearest   the n nearest (paper 3.1), nothing else
//   label     safe, or n states at most in all: the nearest; members of the last set stay until another state
//             is nearer by 5 % (hysteresis). Elsewhere every member has a weight 0 < w <= 1 that is a continuous
//             function of the HIP, so that states enter and leave gradually (RbfFit: a ridge that falls from
//             infinity to 0 as w rises to 1):
//               two sides s = 1, 2 along the main axis of the directions to the nearest states
//               d_s, t_s   distance of a side's nearest state, mean direction to those about as near
//               beta  rises from 0 at d_1 = d_2 / 10 to 1 at d_1 = d_2: how much of a bridge it is
//               n_2 = beta n d_1 / (d_1 + d_2), n never less than weighted_neighbours()
//               key  distance from q_s = x + (d_s - h / 4) t_s (for r: 2 h): of a half ball of the boundary instead of a
//                    layer or two of it, whose polynomial would not be determined
//               w  rises from 0 at the key of rank n_s (between ranks: in proportion) to 1 within band h
//             So the far side of a gap enters when it hardly counts and leaves likewise; in a blank area side
//             2 is empty.

#include <vector>

#include "approx/model.hpp"

namespace forefeel {

struct Neighbour {
  StateId id;
  double weight = 1;  // w
  double near = 1;    // its part in the side that is nearer to the HIP
};

// n where members have weights: of fewer states one that comes or goes decides alone how steep the force is,
// however little it counts. (Of one neighbour there is nothing to weigh.)
constexpr std::size_t weighted_neighbours(const ModelOptions& options) {
  const std::size_t n = options.neighbours, least = options.data == Data::force ? 20 : 16;
  return options.select == Select::label && n > 1 && n < least ? least : n;
}
constexpr std::size_t most_neighbours(const ModelOptions& options) {
  return weighted_neighbours(options) + weighted_neighbours(options) / 6;
}

class NeighbourSelector {
 public:
  NeighbourSelector(const StateSpace& space, const ModelOptions& options);
  // At most options.neighbours of them, or most_neighbours() where some count in part only, ascending ids, into
  // `out`; returns the label of the HIP.
  Label select(const Vec3& hip, std::vector<Neighbour>& out);
  // How much the last set counts as a bridge between two sides: 0 for one side, 1 in the middle.
  double bridge() const { return bridge_; }
  void forget();  // drops hysteresis

 private:
  struct Candidate {
    double key;  // distance [m], less for a member of the last set
    StateId id;
    Vec3 towards;          // unit direction from the HIP
    double beyond[2];      // key of each side, infinite where it is not of that side
    double weight[2];
  };
  struct Side {
    double distance;
    Vec3 towards;
  };
  void take_nearest(const Vec3& hip);
  void take_sides(const Vec3& hip);
  void gather(const Vec3& hip, std::size_t least, double radius);
  Vec3 main_axis(double nearest) const;
  Side side(std::size_t s) const;
  void weigh(std::size_t s, const Vec3& from, double count);
  void keep_first(std::size_t count);

  const StateSpace& space_;
  std::size_t n_, weighted_, most_;  // of members that count in full, where they have weights, and in part
  Select rule_;
  double h_, pulled_, band_;  // the last two in spacings
  std::vector<StateId> found_, last_;
  std::vector<Candidate> candidates_;
  std::vector<Neighbour> chosen_;
  double bridge_ = 0;
  std::vector<double> keys_;
};

}  // namespace forefeel
