#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "approx/judge/leave_one_out.hpp"
#include "approx/predecessors/methods.hpp"
#include "approx/select/updater.hpp"
#include "apps/python/bindings.hpp"
#include "apps/python/space.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/placement/placement_estimate.hpp"

namespace forefeel::python {
namespace {

// The options of `forefeel evaluate`, by the same names.
struct EvaluateOptions {
  std::string method = "rbf";
  std::optional<std::string> kernel, data;
  std::optional<std::size_t> neighbours;
  std::string select = "label";
  std::variant<double, std::string> ridge = 0.0;
  std::optional<double> spacing;
};

template <class Choice>
Choice chosen(const std::string& text, const char* argument, std::initializer_list<Choice> all) {
  std::string names;
  for (const Choice choice : all) {
    if (name(choice) == text) return choice;
    names += (names.empty() ? "" : ", ") + std::string(name(choice));
  }
  throw InputError(argument, fmt::format("is '{:.40}', expected {}", text, names));
}

ModelOptions model_options(const EvaluateOptions& given, const StateSpace& space) {
  bool stiffness = false;
  for (std::uint32_t i = 0; i < space.size() && !stiffness; ++i)
    stiffness = space[StateId{i}].has_stiffness();
  const bool offline = given.method == "offline-rbf";
  ModelOptions options;
  options.kernel = given.kernel
                       ? chosen(*given.kernel, "kernel", {Kernel::linear, Kernel::cubic, Kernel::quintic})
                   : stiffness && !offline ? Kernel::quintic
                                           : Kernel::cubic;
  options.data = given.data ? chosen(*given.data, "data", {Data::force, Data::force_and_stiffness})
                 : stiffness && !offline && options.kernel != Kernel::linear ? Data::force_and_stiffness
                                                                             : Data::force;
  if (options.data == Data::force_and_stiffness && !stiffness)
    throw InputError("data", "no state has a stiffness, expected stiffness, or data=\"force\"");
  options.neighbours = given.neighbours.value_or(options.data == Data::force ? 100 : 25);
  if (options.neighbours < 1 || options.neighbours > 100'000)
    throw InputError("neighbours", fmt::format("is {}, expected 1 to 100000", options.neighbours));
  options.neighbours = std::min(options.neighbours, space.size());
  options.select = chosen(given.select, "select", {Select::label, Select::nearest});
  return options;
}

void set_ridge(ModelOptions& options, const EvaluateOptions& given, const StateSpace& space) {
  if (const double* value = std::get_if<double>(&given.ridge)) {
    if (!(*value >= 0) || !std::isfinite(*value))
      throw InputError("ridge", fmt::format("is {}, expected a number >= 0 or \"auto\"", *value));
    options.ridge = *value;
  } else if (std::get<std::string>(given.ridge) == "auto") {
    options.ridge = choose_ridge(space, options).ridge;
  } else {
    throw InputError("ridge", fmt::format("is '{:.40}', expected a number >= 0 or \"auto\"",
                                          std::get<std::string>(given.ridge)));
  }
}

// Each point has the model of its own neighbours, so the result does not depend on the order of the points.
std::vector<Vec3> forces_at(const StateSpace& space, const ModelOptions& options,
                            const std::vector<Vec3>& points) {
  std::vector<Vec3> forces(points.size());
#pragma omp parallel
  {
    ModelUpdater updater(space, options);
    Model model;
    model.reserve(options);
#pragma omp for schedule(dynamic, 16)
    for (std::size_t i = 0; i < points.size(); ++i) {
      updater.forget();
      updater.update(points[i], model);
      forces[i] = model.force(points[i]);
    }
  }
  return forces;
}

std::vector<Vec3> forces_of_method(Method method, const StateSpace& space, const EvaluateOptions& given,
                                   const ModelOptions& model, const std::vector<Vec3>& points) {
  std::vector<State> states;
  for (std::uint32_t i = 0; i < space.size(); ++i) states.push_back(space[StateId{i}]);
  MethodOptions options;
  options.model = model;
  options.spacing = space.options().spacing;
  if (method == Method::rbf_network)
    options.centres = RbfNetwork::centres_of(states.size(), given.neighbours.value_or(0));
  const Approximation field(method, states, options);
  std::vector<Vec3> forces(points.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < points.size(); ++i) forces[i] = field.force(points[i]);
  return forces;
}

std::vector<Vec3> evaluate(const StateSpace& space, const std::vector<Vec3>& points,
                           const EvaluateOptions& given) {
  const Method method = chosen(given.method, "method",
                               {Method::rbf, Method::trilinear, Method::tricubic, Method::deflection,
                                Method::two_force, Method::offline_rbf, Method::rbf_network});
  ModelOptions options = model_options(given, space);
  set_ridge(options, given, space);
  return method == Method::rbf ? forces_at(space, options, points)
                               : forces_of_method(method, space, given, options, points);
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

EvaluateOptions options_of(const py::kwargs& given) {
  EvaluateOptions options;
  for (const auto& [key, value] : given) {
    const std::string name = py::cast<std::string>(key);
    if (name == "method")
      options.method = py::cast<std::string>(value);
    else if (name == "kernel")
      options.kernel = py::cast<std::optional<std::string>>(value);
    else if (name == "data")
      options.data = py::cast<std::optional<std::string>>(value);
    else if (name == "neighbours")
      options.neighbours = py::cast<std::optional<std::size_t>>(value);
    else if (name == "select")
      options.select = py::cast<std::string>(value);
    else if (name == "ridge")
      options.ridge = py::cast<std::variant<double, std::string>>(value);
    else if (name == "spacing")
      options.spacing = py::cast<std::optional<double>>(value);
    else
      throw py::type_error(
          fmt::format("evaluate() has no option '{:.40}', expected method, kernel, data, neighbours, select, "
                      "ridge or spacing",
                      name));
  }
  return options;
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
        set_ridge(options, wanted, *space.space);
        ModelUpdater updater(*space.space, options);
        return std::make_shared<Model>(updater.model_at(at.front()));
      },
      py::arg("space"), py::arg("hip"));

  module.def(
      "evaluate",
      [](const Doubles& positions, const Doubles& forces, const Doubles& points,
         const std::optional<Doubles>& stiffness, const py::kwargs& given) {
        const EvaluateOptions options = options_of(given);
        std::vector<State> states = states_of(positions, forces, stiffness);
        const std::vector<Vec3> at = points_of(points, "points");
        std::vector<Vec3> found;
        {
          const py::gil_scoped_release released;
          const PySpace space = space_of(std::move(states), options.spacing);
          found = evaluate(*space.space, at, options);
        }
        return array_of(std::span<const Vec3>(found));
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
        const EvaluateOptions options = options_of(given);
        const std::vector<Vec3> at = points_of(points, "points");
        std::vector<Vec3> found;
        {
          const py::gil_scoped_release released;
          found = evaluate(*space.space, at, options);
        }
        return array_of(std::span<const Vec3>(found));
      },
      py::arg("space"), py::arg("points"));
}

}  // namespace forefeel::python
