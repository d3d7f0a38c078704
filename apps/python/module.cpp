// The Python module forefeel._core. The package forefeel (forefeel/__init__.py) is what users import.

#include "apps/python/arrays.hpp"
#include "apps/python/bindings.hpp"
#include "geometry/common/error.hpp"

#ifdef FOREFEEL_PYTHON_EMBEDDED
#include <pybind11/embed.h>
PYBIND11_EMBEDDED_MODULE(_core, module) {
#else
PYBIND11_MODULE(_core, module) {
#endif
  using namespace forefeel::python;
  module.doc() = "Compiled part of forefeel; import forefeel instead.";
  py::register_exception<forefeel::InputError>(module, "InputError", PyExc_ValueError);
  register_state_dtype();
  bind_states(module);
  bind_models(module);
  bind_body(module);
  bind_inputs(module);
  bind_scene(module);
  bind_field(module);
  bind_session(module);
  bind_command(module);
}
