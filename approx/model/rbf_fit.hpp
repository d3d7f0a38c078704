#pragma once
// The coefficients of an RBF model for a set of states:
//   [A P; P^T 0][lambda; c] = [f; 0]      (paper Eq. 2)
// The factor is kept, so that k of n states are replaced in O(k n^2). With K the projected kernel of
// polynomial.hpp (positive definite), K = L L^T and Y = L^-1 [P f], which DenseFactor maintains:
//   c minimises |Y_P c - Y_f|,   lambda = L^-T (Y_f - Y_P c).
// The anchors of K lie around the set. If the set moves away from them or changes its size, it is factorised anew.
//
// Each model is checked at some of its own states. If it misses them by more than a fresh factor would, its
// coefficients are refined: the misfit is computed in twice the working precision and corrected with the present factor
// (Wilkinson 1963, ch. 3). So an updated model is as accurate as one made anew. Where a new factor is faster than
// refinement, as for larger sets, the set is factorised anew instead.
//
// Kernel and degree step down together if the states do not determine the polynomial: r^5 + quadratic ->
// r^3 + linear -> r + constant -> tangent. The rank of P decides, by the pivots of P^T P.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "approx/model/dense_factor.hpp"
#include "approx/model/model.hpp"
#include "approx/model/model_data.hpp"
#include "approx/model/polynomial.hpp"

namespace forefeel {

// A state as the fit needs it.
struct Sample {
  StateId id;
  Vec3 at, force;  // [m], [N]
  Mat3 stiffness;  // [N/m]; NaN where not known
  // 0 < w <= 1: weight of its data. A ridge c (reach h)^k (1 / w - 1) on its rows removes the state gradually as w
  // tends to 0. So the model is a continuous function of the HIP position if w is.
  double weight = 1;
  double reach = 1;       // as in Neighbour
  double near = 1;        // weight in the nearer side of a gap; 1 if there is one side
  bool weighted = false;  // belongs to a set with weights; stays true even if every weight is 1
  bool state = true;      // false: an auxiliary place with data (affine_places in model_options.hpp)
};

// Least radius of a set with weights, in units of ModelOptions::length.
namespace detail {
constexpr double least_size = 0.01;
}

class RbfFit {
 public:
  // Allocates everything for up to `capacity` states.
  RbfFit(const ModelOptions& options, std::size_t capacity);

  std::size_t size() const { return set_.alive; }
  // Factorises the set anew; near-duplicates of earlier samples are dropped.
  void refit(std::span<const Sample> samples);
  // Removes states and adds samples, by an update or by a refit, whichever is faster. Returns true for a
  // refit. All removed ids (ascending) must be in the set; no added id may be.
  bool replace(std::span<const StateId> removed, std::span<const Sample> added);
  // Finds the states to remove and to add in order to get the set `wanted` (ascending ids).
  void difference(std::span<const StateId> wanted, std::vector<StateId>& removed,
                  std::vector<StateId>& missing) const;

  // Writes the model for a HIP at `hip`; bridge and half_ball are NeighbourSelector's bridge() and radius().
  // Allocates only if `out` was not reserved.
  void write(ModelDraft& out, const Vec3& hip, double bridge = 0, double half_ball = 0) {
    write(out.data(), hip, bridge, half_ball);
  }
  // For tests and benches: always update, or always refit.
  enum class Mode { automatic, update, refit };
  void set_mode(Mode mode) { mode_ = mode; }

 private:
  void write(ModelData& out, const Vec3& hip, double bridge, double half_ball);
  struct Level {
    int power = 0, degree = 0;
    bool hermite = false;
  };
  struct Slot {
    Sample sample;
    bool alive = false;
    bool has_stiffness = false;  // known and used
    std::uint32_t dropped = 0;   // functionals without a row of their own
  };

  Level level_for(std::span<const Sample> samples);
  bool level_still_fits();
  void set_frame(std::span<const Sample> samples);
  void factorise(std::span<const Sample> samples);
  bool drops_matter() const;
  void clear();
  void append(std::span<const Sample> added);
  void place(std::size_t slot, const Sample& sample);
  void functionals(std::size_t slot);
  void append_panel(std::size_t first_slot, std::size_t count);
  enum class Outcome { refused, done, stale };  // stale: the set is right, but it must be factorised anew
  Outcome try_update(std::span<const StateId> removed, std::span<const Sample> added);
  bool frame_expired();
  void remove_and_close();
  void enter(std::size_t slot);
  void gather();
  void solve();
  // The set as seen from the HIP; scaled but for the radius [m].
  struct Reach {
    double nearest = 0, farthest = 0;  // distances as far as states count
    double radius = 0;                 // root mean square distance to the mean
    std::size_t first = 0;             // slot of the nearest state
    Vec3 mean = Vec3::Zero();
  };
  Reach reach_from(const Vec3& y);
  double length_of(const Reach& reach, double half_ball);
  void write_tangent(ModelData& out, const Vec3& hip, double bridge, double half_ball);
  void write_mean_tangent(ModelData& out, const Reach& reach);
  void write_hull(const ModelData& out, ModelData::Hull& hull, bool near, const Vec3& centre);
  void write_tangent_of_sum(ModelData& out, const Vec3& hip, std::size_t first, double nearest,
                            double farthest);
  Mat3 slope_of_sum(const ModelData& out, const Vec3& at) const;
  void set_bound(ModelData& out);
  void leave(std::size_t slot);
  bool write_sum(ModelData& out);
  bool has_lost_digits(const ModelData& out);
  bool refit_is_cheaper() const;
  void load_given();
  void solve_correction(const ModelData& out);
  bool refine(ModelData& out);
  double misfit(const ModelData& out);
  void constraint(const ModelData& out, double* rest) const;
  double ridge(std::size_t slot, std::size_t functional) const;
  void correct(ModelData& out, double by);

  // The scaling of the set to the unit ball, and the anchors of K (polynomial.hpp) in it.
  struct Scaling {
    Vec3 centre = Vec3::Zero();           // [m]
    double scale = 1, inverse_scale = 1;  // [m], [1/m]
    std::array<std::array<double, 3>, detail::max_terms> anchors{};
    double anchor_products[detail::max_terms * detail::max_terms] = {};  // G
    Vec3 scaled(const Vec3& x) const { return (x - centre) * inverse_scale; }
  };
  struct Entry {
    StateId id;
    std::uint32_t slot;
  };
  // The states of the set, each in a slot.
  struct Slots {
    // By slot, one array after the other: 1 where it is in use (else all 0), |f|, |K|, f (3), K (9; 0 where not
    // known), the weight (0 for holes), and room for distances.
    enum Array : std::size_t {
      in_use = 0,
      force_norm = 1,
      stiffness_norm = 2,
      force = 3,
      stiffness = 6,
      share = 15,
      away = 16,
      arrays = 17
    };
    std::size_t slots = 0, alive = 0;  // in use, with and without holes
    std::size_t dropped = 0;           // living slots with a functional that was dropped
    bool weighted = false;             // of a set with weights
    std::vector<Slot> slot;
    AlignedArray px, py, pz;  // scaled positions
    std::size_t stride = 0;
    AlignedArray data;                  // arrays x stride
    std::vector<Entry> by_id;           // living slots, ascending ids
    std::vector<std::uint32_t> living;  // slots in the order of the model's centres
    double* array(std::size_t which) { return data.data() + which * stride; }
  };
  // The rows of the factor: per_slot for each slot, 4 with stiffness, else 1.
  struct Rows {
    std::size_t per_slot = 1, terms = 1;  // terms of the polynomial
    double sign = 1;
    std::size_t stride = 0;
    AlignedArray lagrange, dual;  // l_j and v_j of each row: terms x stride
    AlignedArray weight;          // by row: the sign s, 0 for holes
    AlignedArray orthogonal;      // (terms + 6) x stride: Y, then Q and the residual
  };
  struct Solution {
    double coefficient[3][detail::max_terms] = {};
    double upper[detail::max_terms * detail::max_terms] = {};  // of Y_P = Q R; Q stands in Rows::orthogonal
  };
  struct Refinement {
    std::size_t stride = 0;
    AlignedArray given, misfit;                // 12 x stride: f and df/dy of the living slots, and the misfit
    AlignedArray correction, last_correction;  // 3 x Rows::stride: of lambda
    double polynomial[3][detail::max_terms] = {};
  };
  // Loss of accuracy of the factor since the last refit.
  struct Wear {
    std::size_t watched = 0;  // the state that was checked last
    bool updated = false;
    bool worn = false;  // it has lost digits
  };
  // Space for intermediate results, so that nothing is allocated later.
  struct Scratch {
    std::vector<Sample> gathered, added, sorted;
    std::vector<std::size_t> index;      // rows to take out
    std::vector<std::size_t> kept_rows;  // of remove_and_close(), and the new slot of each in `moved`
    std::vector<std::uint32_t> moved;
    AlignedArray hull;  // 3 x Slots::stride: of the living states, moved towards their mean by 1 - weight
  };
  struct Room {
    std::size_t states, slots;  // most states of a set; slots for them, with room for holes
  };

  ModelOptions options_;
  Room room_;
  Mode mode_ = Mode::automatic;
  Level level_;
  Scaling scaling_;
  DenseFactor factor_;
  Slots set_;
  Rows rows_;
  Solution solution_;
  Refinement refinement_;
  Wear wear_;
  Scratch scratch_;
};

}  // namespace forefeel
