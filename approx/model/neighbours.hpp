#pragma once
// The neighbour set of a HIP at x [m]: the states whose data the current model uses, by one of two rules.
//   nearest   the n nearest states (paper 3.1)
//   label     in a safe region, or with at most n states in all: the n nearest; a member of the last set
//             stays until another is nearer by 5 % (hysteresis). Elsewhere: states on all sides, with weights
//             0 < w_i <= 1
// The weights are continuous functions of x, so that states enter and leave gradually (RbfFit: a ridge that falls from
// infinity to 0 as w rises to 1). h [m] is the spacing, d_1 the distance of the nearest state. For each state i, the
// states are viewed along the direction to i; those more than about 70 degrees off count as farther away:
//   d_i, t_i   distance of the nearest state there, mean direction to the states at about that distance
//   beta_i     weight of that side: from 0 at (d_1 + h) / (d_i + h) = 0.1 to 1 at d_i = d_1
//   c_i        (beta_i (d_1 + h) / (d_i + h))^(1/3), so that the number of members falls as 1 / distance
//   key_i      |x_i - x - (d_i - h / 4) t_i| / c_i (kernel r: up to 2.2 h, not h / 4), so that the members
//              of a side fill a half ball at its boundary; one or two layers do not determine the polynomial
//   w_i        rises from 0 at the key of rank n to 1, over a band of fixed width (a multiple of h)
// The candidates are all states within a distance that is a continuous function of x (or all states if they are few);
// c_i falls to 0 over the last 2 h of that distance. n is at least weighted_neighbours(). Between two sides, up to
// bridging_neighbours() states are added to n. n is then a real number, and the key of rank n is interpolated between
// those of the two nearest ranks. So the far side of a gap enters and leaves while its weight is small, and the set of
// sides never changes abruptly.

#include <cstdint>
#include <vector>

#include "approx/model/model_options.hpp"
#include "geometry/coverage/place_walk.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct Neighbour {
  StateId id;
  double weight = 1;  // w
  double near = 1;    // its weight in the side nearer to the HIP
  // Length, in spacings, over which the state determines the force. It is 1 for a state among others. For a lone state
  // beyond a gap it is the width of the gap, and falls to 1 as w rises to 1.
  double reach = 1;
  bool operator==(const Neighbour&) const = default;
};

class NeighbourSelector {
 public:
  NeighbourSelector(const StateSpace& space, const ModelOptions& options);
  // Writes the set to `out`, by ascending ids: at most options.neighbours states, or most_neighbours() with
  // weights. Returns the label of the HIP.
  Label select(const Vec3& hip, std::vector<Neighbour>& out);
  // How far the last set is a bridge between two sides: 0 for one side, 1 in the middle.
  double bridge() const { return set_.bridge; }
  bool weighted() const { return set_.sided; }   // the last set has weights
  double radius() const { return set_.radius; }  // the key of rank n [m]; 0 without weights
  void forget();                                 // forgets the last set, and so the hysteresis

 private:
  struct Nearby {
    double key;  // distance [m], less for a member of the last set; with weights: key_i
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
  struct Sizes;
  struct Widths;
  static Sizes sizes_of(const ModelOptions& options);
  static Widths widths_of(const ModelOptions& options, std::size_t rank, double spacing);
  void take_nearest(const Vec3& hip);
  void take_sides(const Vec3& hip);
  double gather(const Vec3& hip, std::size_t least, double radius);
  void look_round();
  const Eigen::Vector4d& view(std::size_t k);
  void look_along(Nearby& candidate);
  double find_keys(const Vec3& hip, double pulled, double rank);
  double key_of(double rank, double& last);
  double extent(double end);
  double share(double distance) const;
  double two_sided() const;
  void weigh(const Vec3& hip, double end);
  void keep_first(std::size_t count);

  // Numbers of states.
  struct Sizes {
    std::size_t plain, weighted;  // members without weights, and with weights
    std::size_t rank;             // with weights, counting partial ones
    std::size_t bridging, most;   // additional members between two sides; members in all
  };
  struct Widths {
    double spacing;       // h [m]
    double pulled, band;  // in spacings
    double steep;         // power of Neighbour::reach
  };
  // The candidates as seen from the HIP along the fixed views (views.hpp).
  struct Look {
    std::size_t room = 0;                // candidates, padded
    std::vector<double> arrays;          // each of `room`: unit direction (3), distance, apparent distance
    std::vector<Eigen::Vector4d> views;  // direction, distance
    std::vector<char> done;              // by view
    std::vector<double> before;          // the least distance in each cell of directions
  };
  struct Around {
    double nearest = 0;  // d_1 [m]
    double whole = 0;    // for a state nearer than this, all states of its side are candidates [m]
  };
  struct Set {
    bool sided = false;
    double bridge = 0, radius = 0;
  };

  const StateSpace& space_;
  PlaceWalk walk_;
  Sizes sizes_;
  Select rule_;
  Widths widths_;
  std::vector<StateId> found_, last_;
  std::vector<Nearby> candidates_;
  std::vector<Neighbour> chosen_;
  std::vector<double> keys_;
  Look look_;
  Around around_;
  Set set_;
};

}  // namespace forefeel
