#pragma once
// Records the shapes of a run, if they are requested. A shape is kept as the ids and weights of its states:
//   u(x) = sum_i w_i u_i + V g      (scheduling/shape/shape_weights.hpp)
// x [m]: position of the HIP; u_i [m]: displacements of state i; V = du/dx at rest [1]. The displacements u are
// computed from a record twice: when the shape is made, and when the files are written.
//
//   ShapeLog log(body, {.rate = 30});
//   log.learn(state);                   // each state as it becomes known
//   log.take(t, hip);                   // a shape now
//   log.displacements(log.records().back(), u);
//
// Of a body that is touched anywhere, at the site s, with x from it:
//   u(s, x) = V(s) x + sum_i w_i (u_i - V(s_i) x_i)
//   w_i = (1 - d / R) min(|x| / |x_i|, 2)^2 v_i / sum_j v_j,   v_i = (1 / d_i - 1 / R)^2,   d = min_i d_i
// V(s) [1]: du/dx at rest under the pad at s (solver/jet/rest_sites.hpp), three solves for each shape; R: twice the
// radius of the pad; d_i < R: distance of (s, x) and (s_i, x_i) [m]. What V leaves grows with the square of x. At a
// state and in a linear body the shape is exact. Without a touch, u = 0.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "scheduling/shape/shape_weights.hpp"
#include "solver/body/body.hpp"
#include "solver/jet/rest_sites.hpp"

namespace forefeel {

// Options of the body's shape: displacements u [m] at a given rate, in addition to the force that the loop renders.

struct ShapeOptions {
  double rate = 0;              // shapes per second [Hz]; 0: none, at no cost
  bool surface = true;          // nodes of the surface alone; false: of the whole body
  std::size_t checks = 20;      // shapes compared with tight solves after the run
  std::size_t neighbours = 32;  // states that a shape is interpolated from
};

// Throws InputError with the key of an invalid value, as "session.shape_rate".
void check(const ShapeOptions& options);

struct ShapeRecord {
  double t = 0;                       // [s]
  Vec3 at = Vec3::Zero();             // of the HIP [m]
  SurfacePlace site = {};             // of the touch, where the body is touched anywhere
  std::uint32_t known = 0;            // number of known states
  std::vector<std::uint32_t> states;  // ids, in the order in which they became known
  std::vector<float> weights;         // w of each [1]
  Vec3 slope = Vec3::Zero();          // g [m]
  ShapeOrder order = ShapeOrder::slope;
  double largest = 0;  // max |u| over the nodes [m]
};

// Called with each shape on the thread that makes it. displacements: #nodes x 3, row by row [m].
using EachShape = std::function<void(const ShapeRecord&, std::span<const float> displacements)>;

// For one thread at a time.
class ShapeLog {
 public:
  // Solves for V: one factorisation. Throws InputError if the body has no stable rest. sites: of a body that is touched
  // anywhere; null: the contact has one place.
  ShapeLog(std::shared_ptr<const Body> body, const ShapeOptions& options, EachShape each = {},
           std::shared_ptr<const RestSites> sites = nullptr);

  // States are numbered from 0 in the order of these calls. InputError if the state holds no displacements, or
  // those of another mesh.
  void learn(const State& state);
  void take(double t, const Vec3& at, const SurfacePlace& site = {});
  void miss(std::size_t shapes) {
    pace_.missed += shapes;
  }  // counts shapes that were not made for lack of time
  void note_cost(double us) { pace_.cost_us.push_back(static_cast<float>(us)); }

  const ShapeOptions& options() const { return options_; }
  const Body& body() const { return *body_; }
  bool at_sites() const { return sites_ != nullptr; }  // the body is touched anywhere
  // The nodes of a shape in ascending order: those of the surface, or all nodes of the mesh.
  const std::vector<NodeIndex>& nodes() const { return nodes_; }
  std::size_t known() const { return known_.at.size(); }
  std::span<const ShapeRecord> records() const { return records_; }
  std::size_t missed() const { return pace_.missed; }               // real clock
  std::span<const float> cost_us() const { return pace_.cost_us; }  // of each shape; real clock [us]
  void displacements(const ShapeRecord& record, std::vector<float>& u) const;  // as EachShape has them

 private:
  struct Known {  // by state
    std::vector<Vec3> at;
    std::vector<std::shared_ptr<const std::vector<double>>> moved;
    std::vector<Vec3> site;                  // of a body that is touched anywhere
    std::vector<std::vector<float>> curved;  // of such a body: u_i - V(s_i) x_i of the nodes
  };
  struct Pace {  // real clock
    std::vector<float> cost_us;
    std::size_t missed = 0;
  };
  struct Present {                    // the shape that is being made
    std::vector<std::uint32_t> near;  // ids of its states
    std::vector<Vec3> places;
    std::vector<float> u;
  };
  void choose_near(const Vec3& at);
  void weigh(const Vec3& at, ShapeRecord& record) const;
  void weigh_touch(const Vec3& x, ShapeRecord& record) const;
  void add_slope(std::span<const float> slope, const Vec3& g, std::vector<float>& u) const;
  std::vector<float> slope_at(const SurfacePlace& site) const;  // V(s) of the nodes

  std::shared_ptr<const Body> body_;
  ShapeOptions options_;
  EachShape each_;
  std::vector<NodeIndex> nodes_;
  std::vector<float> slope_;  // V of the nodes: #nodes x 3 x 3, row by row
  std::shared_ptr<const RestSites> sites_;
  std::unique_ptr<SiteJets> jets_;  // of the sites
  mutable std::mutex busy_;         // of the jets: files and pictures are made at once
  Known known_;
  std::vector<ShapeRecord> records_;
  Pace pace_;
  Present present_;
};

// "shapes ended after 2.1 s: PROBLEM".
std::string shapes_ended(const ShapeLog& log, const std::exception& problem);

// Throws InputError "NAME: 3 of 40 states hold no displacements …" if shapes cannot be made from the states. name:
// their file.
void check_shapeable(std::span<const State> states, const Body& body, const std::string& name);

}  // namespace forefeel
