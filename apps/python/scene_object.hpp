#pragma once
// A scene as Python sees it: read once, never changed.

#include <memory>

#include "apps/python/arrays.hpp"
#include "apps/scene_input/scene.hpp"

namespace forefeel::python {

struct PyScene {
  std::shared_ptr<const Scene> scene;
};

}  // namespace forefeel::python
