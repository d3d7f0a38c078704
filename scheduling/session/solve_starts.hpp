#pragma once
// The solutions that solves may start from: those of known states, and the last iterates of cancelled solves. One
// thread owns them.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "scheduling/policy/policy.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

class SolveStarts {
 public:
  struct Start {
    Vec3 at;                // displacement
    Vec3 site;              // of the pad, where a body is touched anywhere; else zero
    std::int64_t dispatch;  // its row; -1: known at the start
    std::shared_ptr<const Equilibrium> equilibrium;
  };

  explicit SolveStarts(std::size_t nodes);  // of the body's mesh; limits how many are kept

  // Where there are too many, the one farthest from the hip is forgotten.
  void remember(Start start, const Vec3& hip);
  // Null: rest, which is always known. The pad moves with the site, so ways over the surface count as ways of the tip.
  const Start* nearest(const Candidate& candidate) const;

  void keep_partial(const Candidate& candidate, std::shared_ptr<const Equilibrium> last_iterate);
  std::shared_ptr<const Equilibrium> take_partial(const Candidate& candidate);  // null: none

 private:
  std::size_t most_;
  std::vector<Start> starts_;
  std::unordered_map<std::uint32_t, std::shared_ptr<const Equilibrium>> partial_;  // by Candidate::order
};

}  // namespace forefeel
