#pragma once
// The neighbour set of a HIP: the states whose data the current model uses.
//   nearest   the n nearest (paper 3.1), nothing else
//   label     safe, or n states at most in all: the nearest; members of the last set stay until another state
//             is nearer by 5 % (hysteresis). Elsewhere every member has a weight 0 < w <= 1 that is a
//             continuous function of the HIP x, so that states enter and leave gradually (RbfFit: a ridge
//             that falls from infinity to 0 as w rises to 1). With d_1 the distance of the nearest state, and
//             as seen along the way to state i (what lies more than about 70 degrees off it seems farther,
//             ever more so):
//               d_i, t_i   distance of what is nearest there, mean direction to what is about as near
//               beta_i     how much that side counts: from 0 at (d_1 + h) / (d_i + h) = 0.1 to 1 at d_i = d_1
//               c_i        (beta_i (d_1 + h) / (d_i + h))^(1/3), so that the numbers of members go as 1 / distance
//               key_i      |x_i - x - (d_i - h / 4) t_i| / c_i (for r: up to 2.2 h): of a half ball of the
//                          boundary, not of a layer or two of it, whose polynomial would not be determined
//               w_i        rises from 0 at the key of rank n to 1 within band h
//             All states within a distance that is a continuous function of x are looked at, or all there are
//             where they are few; c_i falls to 0 over the last 2 h before its end.
//             n is never less than weighted_neighbours(), and between two sides up to bridging_neighbours()
//             more come in, the key of a broken rank being between those of two. So the far side of a gap
//             enters when it hardly counts and leaves likewise, and there is no axis and no number of sides
//             that could change at once.

#include <cstdint>
#include <vector>

#include "approx/model/model_options.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct Neighbour {
  StateId id;
  double weight = 1;  // w
  double near = 1;    // its part in the side that is nearer to the HIP
  // Length in spacings over which it decides: 1 of a state among others, of a lone one beyond a gap the
  // gap's, falling to 1 as w rises to 1.
  double reach = 1;
  bool operator==(const Neighbour&) const = default;
};

class NeighbourSelector {
 public:
  NeighbourSelector(const StateSpace& space, const ModelOptions& options);
  // At most options.neighbours of them, or most_neighbours() where some count in part only, ascending ids,
  // into `out`; returns the label of the HIP.
  Label select(const Vec3& hip, std::vector<Neighbour>& out);
  // How much the last set counts as a bridge between two sides: 0 for one side, 1 in the middle.
  double bridge() const { return bridge_; }
  bool weighted() const { return sided_; }
  double radius() const { return radius_; }  // the key of rank n [m]; 0 where there are no weights
  void forget();                             // drops hysteresis

 private:
  struct Candidate {
    double key;  // distance [m], less for a member of the last set; key_i where there are weights
    StateId id;
    Vec3 towards;  // unit direction from the HIP
    double distance;
    double side_at = 0;                // d_i
    Vec3 side_towards = Vec3::Zero();  // t_i
    double share = 0, narrow = 0;      // beta_i, c_i
    double rank = 0;                   // 0 at the last key, 1 a band before it
    std::uint32_t cell = 0;            // of directions
    bool looked = false;
  };
  static constexpr std::size_t arrays = 5;  // of look_round()
  void take_nearest(const Vec3& hip);
  void take_sides(const Vec3& hip);
  double gather(const Vec3& hip, std::size_t least, double radius);
  void look_round();
  const Eigen::Vector4d& view(std::size_t k);
  void look_along(Candidate& candidate);
  double find_keys(const Vec3& hip, double pulled, double rank);
  double key_of(double rank, double& last);
  double extent(double end);
  double share(double distance) const;
  double two_sided() const;
  void weigh(const Vec3& hip, double end);
  void keep_first(std::size_t count);

  const StateSpace& space_;
  std::size_t n_, weighted_, rank_;  // of members that count in full, where they have weights, and in part
  std::size_t bridging_, most_;      // that come in between two sides; and in all
  Select rule_;
  double h_, pulled_, band_;  // the last two in spacings
  double steep_;              // power of the length over which a state decides
  std::vector<StateId> found_, last_;
  std::vector<Candidate> candidates_;
  std::vector<Neighbour> chosen_;
  std::vector<double> keys_, seen_;
  std::vector<Eigen::Vector4d> views_;  // direction, distance
  std::vector<char> views_seen_;
  std::vector<double> before_;  // the least distance in each cell of directions
  std::size_t room_ = 0;
  bool sided_ = false;
  double nearest_ = 0, bridge_ = 0, radius_ = 0;
  double whole_ = 0;  // of no state nearer than this is anything about its side unknown
};

}  // namespace forefeel
