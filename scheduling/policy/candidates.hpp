#pragma once
// The positions that a policy ranks: those where a state may be solved next. They are neither known nor being
// solved.

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

class Candidates {
 public:
  // Positions of known and of failed states are left out. The space must outlive this.
  Candidates(const StateSpace& space, std::span<const State> failed,
             Placement placement = Placement::lattice);

  std::span<const Candidate> open() const { return open_; }
  bool empty() const { return open_.empty(); }
  bool may_grow() const { return placement_ != Placement::lattice; }  // by follow()
  // Takes out the i-th open candidate, to be solved. Indices of the others change. Under `path`, candidates within
  // h / 2 of it are held back. They return if put_back() or fail() reports that it will not become known.
  Candidate take(std::size_t i);
  // Takes out the candidate at rest, under any placement; nullopt if that state was taken or is known.
  std::optional<Candidate> take_rest();
  std::optional<std::size_t> index_of(const Candidate& candidate) const;  // among the open ones
  void put_back(Candidate candidate);  // its solve was cancelled: open again
  void fail(const Vec3& at);           // its solve failed: never open again
  void learn(const Vec3& known);       // a state became known: removes its candidate, updates the distances
  void request_near(const Vec3& hip, double now);  // sets Candidate::requested of those within 2.5 spacings
  // Sets the path ahead, from which `adaptive` and `path` place new candidates.
  void follow(std::span<const Prediction> path, double now);
  // Updates the labels from the space. Labels never get worse, so safe candidates are skipped.
  void refresh_regions();
  Candidate refreshed(Candidate candidate) const;  // with its present label and distance

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
  std::vector<Vec3> under_way_, failed_;                    // under `path`: being solved; failed
  std::vector<Candidate> held_;  // under `path`: within h / 2 of one that is being solved
  std::unique_ptr<AdaptiveLattice> leaves_;
  std::uint32_t order_ = 0;
  bool changed_ = true;
};

}  // namespace forefeel
