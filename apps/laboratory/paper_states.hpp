#pragma once
// The states used in the paper's Figs. 1 to 3: a lattice around a path that starts in a fully known slab and
// leads into the body. Each situation knows a part of them (geometry/coverage/setups.hpp). The path runs
// along the lattice axis nearest to the inward direction of the contact,
//   x(s) = s a,  0 <= s <= depth,   a a signed unit axis
// The known slab lies at s <= 0; in the situation `gap`, a second known slab begins beyond the gap (8 h).
// Nothing is known beyond the end of the path.

#include <string>
#include <string_view>
#include <vector>

#include "approx/model/updater.hpp"
#include "apps/scene/laboratory.hpp"

namespace forefeel {

class PaperStates {
 public:
  // depth of the path and width of the gap, in spacings.
  PaperStates(Laboratory& laboratory, std::size_t depth, const ShowShare& show, std::size_t gap = 8);

  double spacing() const { return h_; }
  double depth() const { return depth_ * h_; }           // of the path [m]
  double far_side() const { return gap_ * h_; }          // where the second slab of `gap` begins [m]
  Vec3 at(double s) const { return s * frame_.col(0); }  // s in [m]
  double along(const Vec3& x) const { return frame_.col(0).dot(x); }
  std::string axis() const;  // "+x", "-z" …

  const std::vector<State>& complete() const { return complete_; }
  std::vector<State> known(std::string_view setup) const;  // full, sparse, gap or blank
  std::size_t unsolved() const { return unsolved_; }       // number of lattice positions without a solution
  StateSpace space(const std::vector<State>& known) const;

 private:
  double h_;
  Box box_;
  Mat3 frame_;
  double depth_;
  int gap_;  // unknown layers in the situation `gap`
  int layers_ = 5, half_width_ = 5;
  int beyond_;  // layers beyond the slab
  std::vector<State> complete_;
  std::size_t unsolved_ = 0;
};

// One method with the settings of the paper or with our defaults.
struct PathMethod {
  std::string name;        // in legends: "r, 100 nearest"
  std::string short_name;  // "r"
  std::string in_words;    // in sentences
  ModelOptions model;
  bool ours = false;
};
PathMethod linear_of_100();  // r with the 100 nearest states
PathMethod cubic_of_100();   // r^3 with the 100 nearest states
PathMethod our_default();
std::vector<PathMethod> paper_methods();  // these three

}  // namespace forefeel
