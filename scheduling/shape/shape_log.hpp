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

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "scheduling/shape/shape_options.hpp"
#include "scheduling/shape/shape_weights.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct ShapeRecord {
  double t = 0;                       // [s]
  Vec3 at = Vec3::Zero();             // of the HIP [m]
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
  // Solves for V: one factorisation. Throws InputError if the body has no stable rest.
  ShapeLog(std::shared_ptr<const Body> body, const ShapeOptions& options, EachShape each = {});

  // States are numbered from 0 in the order of these calls. InputError if the state holds no displacements, or
  // those of another mesh.
  void learn(const State& state);
  void take(double t, const Vec3& at);
  void miss(std::size_t shapes) {
    pace_.missed += shapes;
  }  // counts shapes that were not made for lack of time
  void note_cost(double us) { pace_.cost_us.push_back(static_cast<float>(us)); }

  const ShapeOptions& options() const { return options_; }
  const Body& body() const { return *body_; }
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

  std::shared_ptr<const Body> body_;
  ShapeOptions options_;
  EachShape each_;
  std::vector<NodeIndex> nodes_;
  std::vector<float> slope_;  // V of the nodes: #nodes x 3 x 3, row by row
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
