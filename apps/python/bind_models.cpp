#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "approx/evaluate/evaluate.hpp"
#include "approx/judge/leave_one_out.hpp"
#include "approx/select/updater.hpp"
#include "apps/python/bindings.hpp"
#include "apps/python/space.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/placement/placement_estimate.hpp"

namespace forefeel::python {
namespace {

template <class Choice>
Choice chosen(const std::string& text, const char* argument, std::initializer_list<Choice> all) {
  std::string names;
  for (const Choice choice : all) {
    if (name(choice) == text) return choice;
    names += (names.empty() ? "" : ", ") + std::string(name(choice));
  }
  throw InputError(argument, fmt::format("is '{:.40}', expected {}", text, names));
}

Method method_of(const std::string& text) {
  std::string names = "auto";
  for (const Method method : all_methods()) {
    if (name(method) == text) return method;
    names += ", " + std::string(name(method));
  }
  throw InputError("method", fmt::format("is '{:.40}', expected {}", text, names));
}

void set_ridge(EvaluateOptions& options, const py::handle& value) {
  if (py::isinstance<py::str>(value)) {
    if (py::cast<std::string>(value) != "auto")
      throw InputError("ridge", fmt::format("is '{:.40}', expected a number >= 0 or \"auto\"",
                                            py::cast<std::string>(value)));
    options.choose_ridge = options.choose != true;
    return;
  }
  options.ridge = py::cast<double>(value);
  if (!(*options.ridge >= 0) || !std::isfinite(*options.ridge))
    throw InputError("ridge", fmt::format("is {}, expected a number >= 0 or \"auto\"", *options.ridge));
}

void set_option(EvaluateOptions& options, const std::string& key, const py::handle& value) {
  if (key == "method") {
    const auto method = py::cast<std::string>(value);
    options.choose = method == "auto";
    if (method != "auto") options.method = method_of(method);
  } else if (key == "kernel") {
    options.kernel =
        chosen(py::cast<std::string>(value), "kernel", {Kernel::linear, Kernel::cubic, Kernel::quintic});
  } else if (key == "data") {
    options.data = chosen(py::cast<std::string>(value), "data", {Data::force, Data::force_and_stiffness});
  } else if (key == "neighbours") {
    const auto n = py::cast<std::int64_t>(value);
    if (n < 1 || n > 100'000) throw InputError("neighbours", fmt::format("is {}, expected 1 to 100000", n));
    options.neighbours = static_cast<std::size_t>(n);
  } else if (key == "select") {
    options.select = chosen(py::cast<std::string>(value), "select", {Select::label, Select::nearest});
  } else if (key == "ridge") {
    set_ridge(options, value);
  } else if (key == "spacing") {
    options.spacing = py::cast<double>(value);
    if (!(options.spacing > 0) || !std::isfinite(options.spacing))
      throw InputError("spacing", fmt::format("is {} m, expected a positive number", options.spacing));
  } else {
    throw py::type_error(fmt::format(
        "unknown option '{:.40}', expected method, kernel, data, neighbours, select, ridge or spacing", key));
  }
}

// The options of `forefeel evaluate`, by the same names. None stands for an option that is not given.
EvaluateOptions options_of(const py::kwargs& given) {
  EvaluateOptions options;
  if (given.contains("method") && !given["method"].is_none()) set_option(options, "method", given["method"]);
  for (const auto& [key, value] : given)
    if (!value.is_none()) set_option(options, py::cast<std::string>(key), value);
  return options;
}

std::vector<State> states_in(const StateSpace& space) {
  std::vector<State> states;
  for (std::uint32_t i = 0; i < space.size(); ++i) states.push_back(space[StateId{i}]);
  return states;
}

// The settings in use, and the error to expect where they were chosen.
py::dict description(const Evaluation& made) {
  py::dict out;
  const ModelOptions& model = made.options.model;
  out["method"] = made.chosen ? std::string("auto") : std::string(name(made.method));
  out["kernel"] = std::string(name(model.kernel));
  out["data"] = std::string(name(model.data));
  out["neighbours"] = model.neighbours;
  out["ridge"] = model.ridge;
  out["spacing"] = made.options.spacing;
  out["averaged"] = made.repeated.averaged;
  if (!made.chosen) return out;
  py::dict error;
  error["p50"] = made.chosen->p50, error["p95"] = made.chosen->p95;
  out["expected_error"] = error;
  return out;
}

py::tuple forces_from(const std::vector<State>& states, const std::vector<Vec3>& points,
                      const EvaluateOptions& options) {
  Evaluation made;
  {
    const py::gil_scoped_release released;
    made = forefeel::evaluate(states, points, options);
  }
  return py::make_tuple(array_of(std::span<const Vec3>(made.made.forces)), description(made));
}

// The options of one model; `auto` is not for a single model.
ModelOptions model_options(const EvaluateOptions& given, const StateSpace& space) {
  if (given.choose == true || given.method.value_or(Method::rbf) != Method::rbf)
    throw InputError("method", "expected rbf: model_at() makes one model");
  const bool stiffness = std::ranges::any_of(states_in(space), &State::has_stiffness);
  ModelOptions options;
  options.kernel = given.kernel.value_or(stiffness ? Kernel::quintic : Kernel::cubic);
  options.data = given.data.value_or(stiffness && options.kernel != Kernel::linear ? Data::force_and_stiffness
                                                                                   : Data::force);
  if (options.data == Data::force_and_stiffness && !stiffness)
    throw InputError("data", "no state has a stiffness, expected stiffness, or data=\"force\"");
  options.neighbours =
      std::min(given.neighbours.value_or(options.data == Data::force ? 100 : 25), space.size());
  options.select = given.select.value_or(Select::label);
  options.ridge = given.ridge.value_or(0);
  return options;
}

py::array_t<double> jacobians(const Model& model, const std::vector<Vec3>& points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}, py::ssize_t{3}});
  double* to = out.mutable_data();
  const py::gil_scoped_release released;
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 force;
    Mat3 jacobian;
    model.evaluate(points[i], force, jacobian);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) to[9 * i + static_cast<std::size_t>(3 * r + c)] = jacobian(r, c);
  }
  return out;
}

py::array_t<double> forces(const Model& model, const std::vector<Vec3>& points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* to = out.mutable_data();
  const py::gil_scoped_release released;
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 force = model.force(points[i]);
    std::copy_n(force.data(), 3, to + 3 * i);
  }
  return out;
}

}  // namespace

void bind_models(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>>(module, "Model")
      .def(
          "force", [](const Model& self, const Doubles& at) { return forces(self, points_of(at, "points")); },
          py::arg("points"))
      .def(
          "jacobian",
          [](const Model& self, const Doubles& at) { return jacobians(self, points_of(at, "points")); },
          py::arg("points"))
      .def_property_readonly("states",
                             [](const Model& self) {
                               py::array_t<std::int64_t> ids(static_cast<py::ssize_t>(self.states().size()));
                               std::ranges::transform(self.states(), ids.mutable_data(),
                                                      [](StateId id) { return id.value; });
                               return ids;
                             })
      .def_property_readonly("kernel", [](const Model& self) { return std::string(name(self.kernel())); })
      .def_property_readonly("degree", &Model::degree)
      .def_property_readonly("is_tangent", &Model::is_tangent)
      .def_property_readonly("force_bound", &Model::force_bound)
      .def_property_readonly("trust_distance", &Model::trust_distance)
      .def_property_readonly("hold_distance", &Model::hold_distance);

  module.def(
      "model_at",
      [](const PySpace& space, const Doubles& hip, const py::kwargs& given) {
        const std::vector<Vec3> at = points_of(hip, "hip");
        if (at.size() != 1) throw InputError("hip", "expected one position");
        const EvaluateOptions wanted = options_of(given);
        ModelOptions options = model_options(wanted, *space.space);
        const py::gil_scoped_release released;
        if (wanted.choose_ridge) options.ridge = choose_ridge(*space.space, options).ridge;
        ModelUpdater updater(*space.space, options);
        return std::make_shared<Model>(updater.model_at(at.front()));
      },
      py::arg("space"), py::arg("hip"));

  module.def(
      "evaluate",
      [](const Doubles& positions, const Doubles& forces, const Doubles& points,
         const std::optional<Doubles>& stiffness, const py::kwargs& given) {
        return forces_from(states_of(positions, forces, stiffness), points_of(points, "points"),
                           options_of(given));
      },
      py::arg("positions"), py::arg("forces"), py::arg("points"), py::arg("stiffness") = py::none());

  module.def(
      "estimated_errors",
      [](const PySpace& space, const Doubles& points, double floor) {
        const std::vector<Vec3> at = points_of(points, "points");
        py::array_t<double> out(static_cast<py::ssize_t>(at.size()));
        double* to = out.mutable_data();
        const py::gil_scoped_release released;
        EstimateOptions options;
        options.floor = floor;
        ErrorEstimator estimate(*space.space, options);
        for (std::size_t i = 0; i < at.size(); ++i) to[i] = estimate(at[i]);
        return out;
      },
      py::arg("space"), py::arg("points"), py::arg("floor") = EstimateOptions{}.floor);

  module.def(
      "evaluate_in",
      [](const PySpace& space, const Doubles& points, const py::kwargs& given) {
        EvaluateOptions options = options_of(given);
        if (std::isnan(options.spacing)) options.spacing = space.space->options().spacing;
        return forces_from(states_in(*space.space), points_of(points, "points"), options);
      },
      py::arg("space"), py::arg("points"));
}

}  // namespace forefeel::python
