#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>

#include "approx/error/error_bar.hpp"
#include "approx/error/leave_one_out.hpp"
#include "approx/methods/evaluate.hpp"
#include "approx/model/updater.hpp"
#include "apps/python/bindings.hpp"
#include "apps/python/scene_object.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/placement/candidate_errors.hpp"

namespace forefeel::python {
namespace {

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
  options.model.ridge = cast_to<double>(value, "ridge", "a number or \"auto\"");
  if (!(*options.model.ridge >= 0) || !std::isfinite(*options.model.ridge))
    throw InputError("ridge", fmt::format("is {}, expected a number >= 0 or \"auto\"", *options.model.ridge));
}

void set_option(EvaluateOptions& options, const std::string& key, const py::handle& value) {
  if (key == "method") {
    const auto method = cast_to<std::string>(value, key, "a text");
    options.choose = method == "auto";
    if (method != "auto") options.method = method_of(method);
  } else if (key == "kernel") {
    options.model.kernel = chosen(cast_to<std::string>(value, key, "a text"), "kernel",
                                  std::array{Kernel::linear, Kernel::cubic, Kernel::quintic});
  } else if (key == "data") {
    options.model.data = chosen(cast_to<std::string>(value, key, "a text"), "data",
                                std::array{Data::force, Data::force_and_stiffness, Data::jet});
  } else if (key == "neighbours") {
    const auto n = cast_to<std::int64_t>(value, key, "a whole number");
    if (n < 1 || n > 100'000) throw InputError("neighbours", fmt::format("is {}, expected 1 to 100000", n));
    options.model.neighbours = static_cast<std::size_t>(n);
  } else if (key == "select") {
    options.model.select = chosen(cast_to<std::string>(value, key, "a text"), "select",
                                  std::array{Select::label, Select::nearest});
  } else if (key == "ridge") {
    set_ridge(options, value);
  } else if (key == "noise" || key == "position_noise") {
    const auto noise = cast_to<double>(value, key, "a number");
    if (!(noise >= 0) || !std::isfinite(noise))
      throw InputError(key, fmt::format("is {}, expected a number from 0", noise));
    (key == "noise" ? options.noise.force : options.noise.position) = noise;
  } else if (key == "stiffest") {
    options.stiffest = cast_to<double>(value, key, "a number");
    if (!(*options.stiffest > 0) || !std::isfinite(*options.stiffest))
      throw InputError(key, fmt::format("is {}, expected a number above 0 [N/m]", *options.stiffest));
  } else if (key == "bars") {
    options.bars = cast_to<bool>(value, key, "True or False");
  } else if (key == "spacing") {
    options.spacing = cast_to<double>(value, key, "a number");
    check_spacing(options.spacing);
  } else {
    throw py::type_error(
        fmt::format("unknown option '{:.40}', expected method, kernel, data, neighbours, select, ridge, "
                    "spacing, noise, position_noise, stiffest or "
                    "bars",
                    key));
  }
}

// The options of `forefeel evaluate`, by the same names. None means that an option is not given.
EvaluateOptions options_of(const py::kwargs& given) {
  EvaluateOptions options;
  if (given.contains("method") && !given["method"].is_none()) set_option(options, "method", given["method"]);
  for (const auto& [key, value] : given)
    if (!value.is_none()) set_option(options, py::cast<std::string>(key), value);
  return options;
}

// Half-widths (m, levels) [N]; infinite where they are not known.
py::array_t<double> widths(std::span<const BarWidths> bars) {
  py::array_t<double> out(
      {static_cast<py::ssize_t>(bars.size()), static_cast<py::ssize_t>(bar_levels.size())});
  double* to = out.mutable_data();
  for (const BarWidths& bar : bars) to = std::copy(bar.begin(), bar.end(), to);
  return out;
}

// The settings in use, and the error to expect where they were chosen.
py::dict description(const Evaluation& made) {
  py::dict out;
  const ModelOptions& model = made.options.model;
  out["method"] = made.chosen ? std::string("auto") : std::string(name(made.method));
  out["kernel"] = std::string(made.chosen && made.chosen->field ? name(made.chosen->field->law.smoothness)
                                                                : name(model.kernel));
  out["data"] = std::string(name(model.data));
  out["neighbours"] = model.neighbours;
  out["ridge"] = model.ridge;
  out["spacing"] = made.options.spacing;
  out["averaged"] = made.repeated.averaged;
  if (made.bars) {
    out["bars"] = widths(made.bars->at);
    const BarCover cover = made.bars->measured->cover();
    out["error_bar"] = py::dict(py::arg("levels") = bar_levels, py::arg("coverage") = cover.inside,
                                py::arg("samples") = cover.samples, py::arg("width_p50") = cover.width_p50);
  }
  if (made.field) out["noise"] = made.field->law.noise;
  if (!made.chosen) return out;
  out["groups"] = made.chosen->groups;
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
ModelOptions model_options(const EvaluateOptions& given, const PySpace& from) {
  const StateSpace& space = *from.space;
  if (given.choose == true || given.method.value_or(Method::rbf) != Method::rbf)
    throw InputError("method", "expected rbf: model_at() makes one model");
  const bool stiffness = std::ranges::any_of(from.states(), &State::has_stiffness);
  const ModelOptions options = wished_model(given.model, stiffness, space.size());
  if (options.data == Data::force_and_stiffness && !stiffness)
    throw InputError("data", "no state has a stiffness, expected stiffness, or data=\"force\"");
  return options;
}

struct PyModel {
  std::shared_ptr<const Model> model;
  std::vector<std::int64_t> rows;
  PySpace space;
  ModelOptions options;
  // Measured when they are first asked for.
  struct Bars {
    std::once_flag once;
    OfflineBars made;
  };
  std::shared_ptr<Bars> bars = std::make_shared<Bars>();
};

std::size_t level_index(double level) {
  for (std::size_t i = 0; i < bar_levels.size(); ++i)
    if (level == bar_levels[i]) return i;
  throw InputError("level", fmt::format("is {}, expected {}", level, fmt::join(bar_levels, ", ")));
}

py::array_t<double> error_bars(const PyModel& self, const Points& points, double level) {
  const std::size_t which = level_index(level);
  // The space of a PlannerView lives as long as the view, which may be over.
  if (self.space.space.use_count() == 0)
    throw InputError("error_bar",
                     "the model is of a planner's view, expected one of a StateSpace of your own");
  py::array_t<double> out(static_cast<py::ssize_t>(points.size()));
  double* to = out.mutable_data();
  const py::gil_scoped_release released;
  const StateSpace& space = *self.space.space;
  std::call_once(self.bars->once, [&] {
    const double h = space.options().spacing;
    std::vector<SeenPlace> outside(PlaceLocator::directions);  // one spacing outside, in all directions
    for (std::size_t k = 0; k < outside.size(); ++k)
      outside[k] = {.away = h, .beyond = h, .direction = k, .outside = true};
    self.bars->made =
        measure_bars(self.space.states(), {.model = self.options, .spacing = h, .wanted = outside});
  });
  const OfflineBars& bars = self.bars->made;
  const PlaceLocator locate(space);
#pragma omp parallel for schedule(dynamic, 256)
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 at = points[i];
    to[i] = bars.at({.label = space.label(at),
                     .outside = locate(at).outside,
                     .scale = scale_at(space, at, self.model->force(at))})[which];
  }
  return out;
}

py::array_t<double> jacobians(const Model& model, const Points& points) {
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

py::array_t<double> forces(const Model& model, const Points& points) {
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

// Seconds of the loop in C++ that force() is compared with: points and forces are C++ vectors.
double loop_seconds(const PyModel& self, const Doubles& points) {
  const std::vector<Vec3> at = points_of(points, "points");
  const py::gil_scoped_release released;
  const auto start = std::chrono::steady_clock::now();
  std::vector<Vec3> out(at.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < at.size(); ++i) out[i] = self.model->force(at[i]);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void bind_model(py::module_& module) {
  py::class_<PyModel>(module, "Model",
                      "The force around a place, fitted to states near it. Made by StateSpace.model_at().")
      .def(
          "force",
          [](const PyModel& self, const Doubles& at) { return forces(*self.model, Points(at, "points")); },
          py::arg("points"), "Forces (m, 3) [N] at points (m, 3) [m]; uses all cores.")
      .def(
          "jacobian",
          [](const PyModel& self, const Doubles& at) { return jacobians(*self.model, Points(at, "points")); },
          py::arg("points"), "Derivatives of the force (m, 3, 3) [N/m]: [k, i, j] is df_i/dx_j at points[k].")
      .def(
          "error_bar",
          [](const PyModel& self, const Doubles& at, double level) {
            return error_bars(self, Points(at, "points"), level);
          },
          py::arg("points"), py::arg("level") = 0.95,
          "Half-widths (m,) [N] of the error bars at points (m, 3) [m]: the force() there is nearer to the "
          "true force "
          "than this at the share `level` (0.9, 0.95 or 0.99) of the places. From known forces left out in "
          "groups, "
          "measured at the first call (a second or so); inf where the states are too few. The "
          "model is of "
          "one place: "
          "far from it, use StateSpace.error_bar().")
      .def("_loop_seconds", &loop_seconds, py::arg("points"))
      .def_property_readonly(
          "states", [](const PyModel& self) { return py::array_t<std::int64_t>(py::cast(self.rows)); },
          "Rows int64 (n,) of the states that the model uses, in the array that the space was made from.")
      .def_property_readonly(
          "kernel", [](const PyModel& self) { return std::string(name(self.model->kernel())); },
          "linear, cubic or quintic; a simpler one than asked for where the states do not determine it.")
      .def_property_readonly(
          "degree", [](const PyModel& self) { return self.model->degree(); },
          "Degree of the polynomial part: 0, 1 or 2.")
      .def_property_readonly(
          "is_tangent", [](const PyModel& self) { return self.model->is_tangent(); },
          "True: only the tangent of the nearest state.")
      .def_property_readonly(
          "force_bound", [](const PyModel& self) { return self.model->force_bound(); },
          "No force of the model is larger [N].")
      .def_property_readonly(
          "trust_distance", [](const PyModel& self) { return self.model->trust_distance(); },
          "Distance from its states beyond which the model fades to their tangents [m].")
      .def_property_readonly(
          "hold_distance", [](const PyModel& self) { return self.model->hold_distance(); },
          "Distance from its states beyond which the force is held constant [m].");
}

}  // namespace

void bind_models(py::module_& module) {
  bind_model(module);
  module.def(
      "model_at",
      [](const PySpace& space, const Doubles& hip, const py::kwargs& given) {
        const std::vector<Vec3> at = points_of(hip, "hip");
        if (at.size() != 1) throw InputError("hip", "expected one position");
        const EvaluateOptions wanted = options_of(given);
        ModelOptions options = model_options(wanted, space);
        const py::gil_scoped_release released;
        if (wanted.choose_ridge) options.ridge = choose_ridge(*space.space, options).ridge;
        ModelUpdater updater(*space.space, options);
        PyModel made{std::make_shared<const Model>(updater.model_at(at.front())), {}, space, options};
        for (const StateId id : made.model->states()) made.rows.push_back(space.row(id));
        return made;
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

  py::class_<CandidateErrors>(module, "CandidateErrors")
      .def(py::init([](const Doubles& candidates, double spacing, double floor) {
             EstimateOptions options;
             options.floor = floor;
             std::vector<Vec3> at = points_of(candidates, "candidates");
             StateSpaceOptions space{.spacing = spacing, .box = {at.front(), at.front()}};
             for (const Vec3& x : at) {
               space.box.low = space.box.low.cwiseMin(x);
               space.box.high = space.box.high.cwiseMax(x);
             }
             return std::make_unique<CandidateErrors>(std::move(at), space, options);
           }),
           py::arg("candidates"), py::arg("spacing"), py::arg("floor"))
      .def(
          "tell",
          [](CandidateErrors& errors, const Doubles& at, const Doubles& force, const Doubles& stiffness) {
            for (const State& state : states_of(at, force, stiffness)) errors.tell(state);
          },
          py::arg("at"), py::arg("force"), py::arg("stiffness"))
      .def(
          "worst",
          [](CandidateErrors& errors, const Doubles& weights) -> std::optional<std::size_t> {
            const std::span<const double> all(weights.data(), static_cast<std::size_t>(weights.size()));
            const py::gil_scoped_release released;
            const auto worst = errors.worst(all);
            return worst ? std::optional(worst->index) : std::nullopt;
          },
          py::arg("weights"))
      .def_property_readonly("judged", &CandidateErrors::judged);

  module.def(
      "evaluate_in",
      [](const PySpace& space, const Doubles& points, const py::kwargs& given) {
        EvaluateOptions options = options_of(given);
        if (std::isnan(options.spacing)) options.spacing = space.space->options().spacing;
        return forces_from(space.states(), points_of(points, "points"), options);
      },
      py::arg("space"), py::arg("points"));
}

}  // namespace forefeel::python
