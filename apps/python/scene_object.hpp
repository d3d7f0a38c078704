#pragma once
// A scene and a body as Python sees them: made once, never changed.

#include <memory>

#include "apps/python/arrays.hpp"
#include "apps/scene/scene.hpp"

namespace forefeel::python {

struct PyBody {
  std::shared_ptr<const Body> body;
  std::vector<std::string> warnings = {};
};

struct PyScene {
  std::shared_ptr<const Scene> scene;
};

}  // namespace forefeel::python
