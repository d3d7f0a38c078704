#pragma once
// The neighbour set of a HIP: the states whose data the current model uses.
//   nearest   the n nearest (paper 3.1), nothing else
//   label     safe, or n states at most in all: the nearest. Elsewhere the two sides of the HIP are told
//   apart by
//             the plane through it that faces the nearest states. Side 1 (they) and side 2 (across) share n
//             by their distances,
//               n_2 = n d_1 / (d_1 + d_2), fading to none as d_2 reaches the bridge's limit of 8 h,
//             so that the far side of a gap enters when it hardly counts and leaves likewise (in a blank area
//             side 2 is empty). Each side gives the states nearest to the HIP pulled back to a quarter
//             spacing from it: a half ball of the boundary instead of a layer or two of it, whose polynomial
//             would not be determined.
// Members of the last set stay until another state is nearer by 5 % (hysteresis).

#include <cstdint>
#include <vector>

#include "approx/model.hpp"

namespace forefeel {

class NeighbourSelector {
 public:
  NeighbourSelector(const StateSpace& space, const ModelOptions& options);
  // At most options.neighbours ids, ascending, into `out`; returns the label of the HIP.
  Label select(const Vec3& hip, std::vector<StateId>& out);
  void forget();  // drops hysteresis

 private:
  struct Candidate {
    double key;  // distance [m], less for a member of the last set
    StateId id;
    std::uint8_t side;
  };
  void take_nearest(const Vec3& hip);
  void take_sides(const Vec3& hip);
  void gather(const Vec3& q, std::size_t least, double radius);
  Vec3 towards(const Vec3& hip, std::uint8_t side, double& distance) const;
  void prefer_members();
  void keep_first(std::uint8_t side, std::size_t count);

  const StateSpace& space_;
  std::size_t n_;
  Select rule_;
  std::vector<StateId> found_, last_, chosen_;
  std::vector<Candidate> candidates_;
};

}  // namespace forefeel
