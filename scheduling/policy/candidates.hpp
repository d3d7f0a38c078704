#pragma once
// Where a state may be solved next and nobody has solved or is solving one: what a policy ranks.
//   lattice    the points {k h}^3 in the box
//   adaptive   the corners of an octree of leaves 4 h wide; a leaf the hand comes into is split, down to h, once its
//              corners are taken
//   path       every second lattice point each way, and besides, anew in each planning step, points of the predicted
//              path; none nearer than h / 2 to a state that is known or being solved

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "geometry/index/adaptive_lattice.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

enum class Placement { lattice, adaptive, path };

class Candidates {
 public:
  // Without those known in the space and those in `failed`. The space must outlive this.
  Candidates(const StateSpace& space, std::span<const State> failed,
             Placement placement = Placement::lattice);

  std::span<const Candidate> open() const { return open_; }
  bool empty() const { return open_.empty(); }
  bool may_grow() const { return placement_ != Placement::lattice; }  // by follow()
  // The i-th open one, taken out to be solved. The others change places, and under `path` those within h / 2 of it wait
  // until put_back() or fail() says that it will not be known.
  Candidate take(std::size_t i);
  // The one at rest, whatever the placement; nothing where that state was taken or is known.
  std::optional<Candidate> take_rest();
  std::optional<std::size_t> index_of(const Candidate& candidate) const;  // among the open ones
  void put_back(Candidate candidate);                                     // a cancelled one
  void fail(const Vec3& at);      // its solve failed: no candidate any more
  void learn(const Vec3& known);  // a state became known: it is no candidate, and distances shrink
  void request_near(const Vec3& hip, double now);
  // The motion ahead, from which `adaptive` and `path` place.
  void follow(std::span<const Prediction> path, double now);
  // Labels of the regions as of the space now. Labels never get worse, so safe ones are not asked again.
  void refresh_regions();
  Candidate refreshed(Candidate candidate) const;  // label and distance as of now

 private:
  std::uint64_t key(const Vec3& x) const;
  void add(const Vec3& x, bool passing);
  void open_one(const Candidate& candidate);
  Candidate remove(std::size_t i);  // the last one takes its place
  bool too_near(const Vec3& x, std::span<const Vec3> places) const;
  void hold_back(const Vec3& at);
  void release();
  void split_leaves(std::span<const Prediction> path);
  bool corners_are_taken(const LatticeLeaf& leaf) const;

  const StateSpace& space_;
  Placement placement_;
  std::vector<Candidate> open_;
  std::unordered_map<std::uint64_t, std::uint32_t> place_;  // position -> index in open_
  std::unordered_map<std::uint64_t, bool> gone_;            // known at the start, failed, or seen before
  std::vector<Vec3> under_way_, failed_;                    // `path`: being solved; failed solves
  std::vector<Candidate> held_;                             // `path`: too near to one that is being solved
  std::unique_ptr<AdaptiveLattice> leaves_;
  std::uint32_t order_ = 0;
  bool changed_ = true;
};

}  // namespace forefeel
