#pragma once
// The lattice points of a state space that nobody has solved or is solving: what a policy ranks.

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "scheduling/policy.hpp"

namespace forefeel {

class Candidates {
 public:
  // Without those known in the space and those in `failed`. The space must outlive this.
  Candidates(const StateSpace& space, std::span<const State> failed);

  std::span<const Candidate> open() const { return open_; }
  bool empty() const { return open_.empty(); }
  // The i-th open one, taken out; the last one takes its place.
  Candidate take(std::size_t i);
  void put_back(Candidate candidate);            // a cancelled one
  void learn(const Vec3& known);                 // a state became known: it is no candidate, and distances shrink
  void request_near(const Vec3& hip, double now);
  // Labels and distances as of the space now. Labels never get worse, so safe ones are not asked again.
  void refresh();
  Candidate refreshed(Candidate candidate) const;

 private:
  std::uint64_t key(const Vec3& x) const;

  const StateSpace& space_;
  std::vector<Candidate> open_;
  std::unordered_map<std::uint64_t, std::uint32_t> place_;   // lattice point -> index in open_
  bool changed_ = true;
};

}  // namespace forefeel
