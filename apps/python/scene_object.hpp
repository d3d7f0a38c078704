#pragma once
// A scene and a body as Python sees them: made once, never changed.

#include <memory>

#include "apps/python/arrays.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel::python {

struct PyBody {
  std::shared_ptr<const Body> body;
  std::vector<std::string> warnings = {};
};

struct PyScene {
  std::shared_ptr<const Scene> scene;
};

// A state space as Python sees it: shared, and never changed after construction.

struct PySpace {
  std::shared_ptr<const StateSpace> space;
  // Row of the caller's array for each state id. Empty: the ids themselves.
  std::vector<std::int64_t> rows = {};

  // Its states in the order of the rows.
  std::vector<State> states() const;
  std::int64_t row(StateId id) const { return rows.empty() ? std::int64_t{id.value} : rows[id.value]; }
};

// Usable states only, inserted as `forefeel classify` does; the first of repeated positions is kept.
// spacing [m]: nullopt takes the median distance of the states.
PySpace space_of(std::vector<State> states, std::optional<double> spacing,
                 const CoverageOptions& thresholds = {});

}  // namespace forefeel::python
