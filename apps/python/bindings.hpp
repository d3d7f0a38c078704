#pragma once
// The parts of the Python module forefeel._core. Each function adds its classes and functions.

#include <pybind11/pybind11.h>

namespace forefeel::python {

void bind_states(pybind11::module_& module);   // reading, writing, StateSpace, classify
void bind_models(pybind11::module_& module);   // Model, evaluate
void bind_body(pybind11::module_& module);     // Body, read_mesh
void bind_inputs(pybind11::module_& module);   // read_inputs
void bind_scene(pybind11::module_& module);    // Scene
void bind_field(pybind11::module_& module);    // SurfaceField
void bind_session(pybind11::module_& module);  // run_session, policies, predictors and devices in Python
void bind_command(pybind11::module_& module);  // the commands of forefeel, with parts registered from Python

}  // namespace forefeel::python
