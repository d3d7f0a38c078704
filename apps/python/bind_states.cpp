#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "apps/python/bindings.hpp"
#include "apps/python/scene_object.hpp"
#include "geometry/common/error.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/morton_order.hpp"
#include "geometry/index/path_walk.hpp"
#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/stiffness_agreement.hpp"

namespace forefeel::python {

PySpace space_of(std::vector<State> states, std::optional<double> spacing,
                 const CoverageOptions& thresholds) {
  std::vector<std::int64_t> rows(states.size());
  std::iota(rows.begin(), rows.end(), std::int64_t{0});
  std::erase_if(rows, [&](std::int64_t i) { return !states[static_cast<std::size_t>(i)].usable(); });
  std::erase_if(states, [](const State& s) { return !s.usable(); });
  if (states.empty()) throw InputError("states", "hold no usable state, expected at least one");
  StateSpaceOptions options;
  options.spacing = spacing ? *spacing : estimate_spacing(states);
  if (spacing) check_spacing(*spacing);
  if (!(options.spacing > 0) || !std::isfinite(options.spacing))
    throw InputError("spacing", "is not given, and a single position has none, expected metres");
  options.coverage = thresholds;
  options.box = {states.front().at, states.front().at};
  for (const State& s : states) {
    options.box.low = options.box.low.cwiseMin(s.at);
    options.box.high = options.box.high.cwiseMax(s.at);
  }
  const auto space = std::make_shared<StateSpace>(options);
  std::vector<std::int64_t> inserted;  // repeated positions are left out
  inserted.reserve(states.size());
  for (const std::uint32_t i : morton_order(states, options.box, options.spacing))  // as `forefeel classify`
    if (space->insert(std::move(states[i])).is_new) inserted.push_back(rows[i]);
  return {space, std::move(inserted)};
}

std::vector<State> PySpace::states() const {
  std::vector<std::uint32_t> order(space->size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return row({i}); });
  std::vector<State> states;
  states.reserve(order.size());
  for (const std::uint32_t i : order) states.push_back((*space)[StateId{i}]);
  return states;
}

namespace {

constexpr double largest_spacing = 1e6;  // [m]; squares of larger values may overflow

std::optional<double> checked(std::optional<double> spacing) {
  if (spacing && !(*spacing > 0 && *spacing <= largest_spacing))
    throw InputError("spacing",
                     fmt::format("is {} m, expected a number in (0, {:.0e}]", *spacing, largest_spacing));
  return spacing;
}

// Applies `each(i)` to all points, in parallel and without the interpreter's lock.
template <class Each>
void for_all(std::size_t n, const Each& each) {
  const py::gil_scoped_release released;
#pragma omp parallel for schedule(dynamic, 256)
  for (std::size_t i = 0; i < n; ++i) each(i);
}

py::array_t<std::uint8_t> labels(const StateSpace& space, const Points& points) {
  py::array_t<std::uint8_t> out(static_cast<py::ssize_t>(points.size()));
  std::uint8_t* to = out.mutable_data();
  const py::gil_scoped_release released;
#pragma omp parallel
  {
    PathWalk walk;
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < points.size(); ++i)
      to[i] = static_cast<std::uint8_t>(space.label(points[i], walk));
  }
  return out;
}

// Seconds of the loop in C++ that label() is compared with: points and labels are C++ vectors.
double loop_seconds(const PySpace& self, const Doubles& points) {
  const std::vector<Vec3> at = points_of(points, "points");
  const py::gil_scoped_release released;
  const auto start = std::chrono::steady_clock::now();
  std::vector<Label> out(at.size());
#pragma omp parallel
  {
    PathWalk walk;
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < at.size(); ++i) out[i] = self.space->label(at[i], walk);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

py::array_t<double> measure(const StateSpace& space, const Points& points, double Coverage::*field) {
  py::array_t<double> out(static_cast<py::ssize_t>(points.size()));
  double* to = out.mutable_data();
  for_all(points.size(), [&](std::size_t i) { to[i] = space.coverage(points[i]).*field; });
  return out;
}

struct ComponentRow {
  std::uint8_t label;
  double volume, x, y, z, low_x, low_y, low_z, high_x, high_y, high_z;
};
struct HoleRow {
  double radius, x, y, z;
};

// Volumes by label, and the components and holes as rows.
py::tuple cover(const PySpace& self) {
  RegionSummary summary;
  std::vector<EmptyBall> balls;
  {
    const py::gil_scoped_release released;
    const StateSpaceOptions& options = self.space->options();
    double cubes = 1;
    for (int axis = 0; axis < 3; ++axis)
      cubes *= std::max(1.0, 4 * options.box.size()[axis] / options.spacing);
    if (!(cubes <= 1e9))
      throw InputError(
          "spacing", fmt::format("is {:.3g} m: the box of the states holds {:.2g} cubes of a quarter of it, "
                                 "expected at most 1e9",
                                 options.spacing, cubes));
    summary = self.space->regions().summary(false);
    balls = empty_balls(self.space->delaunay(), options.box, options.spacing);
  }
  py::array_t<double> volume(4, summary.volume.values.data());
  py::array_t<ComponentRow> components = zero_rows<ComponentRow>(summary.components.size());
  ComponentRow* to = components.mutable_data();
  for (const RegionComponent& c : summary.components) {
    const Vec3 &at = c.inner, &low = c.bounds.low, &high = c.bounds.high;
    *to++ = {static_cast<std::uint8_t>(c.label),
             c.volume,
             at.x(),
             at.y(),
             at.z(),
             low.x(),
             low.y(),
             low.z(),
             high.x(),
             high.y(),
             high.z()};
  }
  py::array_t<HoleRow> holes = zero_rows<HoleRow>(balls.size());
  HoleRow* hole = holes.mutable_data();
  for (const EmptyBall& ball : balls)
    *hole++ = {ball.radius, ball.centre.x(), ball.centre.y(), ball.centre.z()};
  return py::make_tuple(volume, components, holes);
}

py::tuple nearest(const PySpace& self, const Points& points, std::size_t n) {
  const StateSpace& space = *self.space;
  n = std::min(n, space.size());
  const auto rows = static_cast<py::ssize_t>(points.size()), columns = static_cast<py::ssize_t>(n);
  py::array_t<std::int64_t> ids({rows, columns});
  py::array_t<double> distances({rows, columns});
  std::int64_t* id = ids.mutable_data();
  double* distance = distances.mutable_data();
  for_all(points.size(), [&](std::size_t i) {
    std::vector<StateId> found;
    space.nearest(points[i], n, found);
    for (std::size_t k = 0; k < n; ++k) {
      id[i * n + k] = self.row(found[k]);
      distance[i * n + k] = (space[found[k]].at - points[i]).norm();
    }
  });
  return py::make_tuple(ids, distances);
}

py::dict read_states(const std::filesystem::path& file) {
  LoadedStates loaded;
  {
    const py::gil_scoped_release released;
    loaded = load_states(file, Tells::places);
  }
  py::dict out;
  out["states"] = array_of(loaded.states);
  const bool jets = std::ranges::any_of(loaded.states, [](const State& s) { return s.jet != nullptr; });
  out["jets"] = jets ? py::object(jets_of(loaded.states)) : py::none();
  out["spacing"] = loaded.header.spacing;
  out["box"] = array_of(loaded.header.box);
  out["identity"] =
      std::map<std::string, std::string>(loaded.header.identity.begin(), loaded.header.identity.end());
  out["notes"] = loaded.header.notes;
  out["damaged"] = loaded.damaged;
  return out;
}

void write_states(const std::filesystem::path& file, const py::array_t<StateRow>& rows, double spacing) {
  check_spacing(spacing);
  std::error_code error;
  if (std::filesystem::exists(file, error))
    throw InputError(file.string(), "exists already, expected a new name");
  const std::vector<State> states = states_of(rows);
  const py::gil_scoped_release released;
  StateFileHeader header;
  header.spacing = spacing;
  if (!states.empty()) header.box = {states.front().at, states.front().at};
  for (const State& s : states) {
    header.box.low = header.box.low.cwiseMin(s.at);
    header.box.high = header.box.high.cwiseMax(s.at);
  }
  header.notes["source"] = "import from Python";
  StateFile::open_or_create(file, header).replace(header, states);
}

void bind_thresholds(py::module_& module) {
  py::class_<CoverageOptions>(
      module, "Thresholds",
      "Thresholds of the labels, as the options of `forefeel classify`; h is the spacing.")
      .def(py::init<>())
      .def_readwrite("safe_spread", &CoverageOptions::safe_spread, "Safe: spread at most this many h")
      .def_readwrite("safe_cone_radius", &CoverageOptions::safe_cone_radius,
                     "Safe: enclosed by states within this many h")
      .def_readwrite("safe_angle_deg", &CoverageOptions::safe_angle_deg,
                     "Safe: largest empty cone below this half-angle [deg]")
      .def_readwrite("sparse_distance", &CoverageOptions::sparse_distance,
                     "Sparse: a state within this many h")
      .def_readwrite("gap_cone_radius", &CoverageOptions::gap_cone_radius,
                     "Gap: states on both sides within this many h")
      .def_readwrite("gap_angle_deg", &CoverageOptions::gap_angle_deg,
                     "Gap: largest empty cone at most this half-angle [deg]");
}

void bind_space(py::module_& module) {
  py::class_<PySpace>(module, "StateSpace")
      .def(py::init([](const py::array_t<StateRow>& rows, std::optional<double> spacing,
                       const CoverageOptions& thresholds) {
             std::vector<State> states = states_of(rows);
             const py::gil_scoped_release released;
             return space_of(std::move(states), checked(spacing), thresholds);
           }),
           py::arg("states"), py::arg("spacing") = py::none(),
           py::arg_v("thresholds", CoverageOptions{}, "Thresholds()"))
      .def("__len__", [](const PySpace& self) { return self.space->size(); })
      .def_property_readonly("spacing", [](const PySpace& self) { return self.space->options().spacing; })
      .def_property_readonly("box", [](const PySpace& self) { return array_of(self.space->options().box); })
      .def_property_readonly("states", [](const PySpace& self) { return array_of(self.states()); })
      .def_property_readonly("rows",
                             [](const PySpace& self) {
                               py::array_t<std::int64_t> rows(static_cast<py::ssize_t>(self.space->size()));
                               std::int64_t* to = rows.mutable_data();
                               for (std::uint32_t i = 0; i < self.space->size(); ++i) to[i] = self.row({i});
                               std::sort(to, to + rows.size());
                               return rows;
                             })
      .def(
          "label",
          [](const PySpace& self, const Doubles& at) { return labels(*self.space, Points(at, "points")); },
          py::arg("points"))
      .def(
          "spread",
          [](const PySpace& self, const Doubles& at) {
            return measure(*self.space, Points(at, "points"), &Coverage::spread);
          },
          py::arg("points"))
      .def(
          "distance",
          [](const PySpace& self, const Doubles& at) {
            return measure(*self.space, Points(at, "points"), &Coverage::delta);
          },
          py::arg("points"))
      .def("_coverage", &cover)
      .def("_loop_seconds", &loop_seconds, py::arg("points"))
      .def(
          "nearest",
          [](const PySpace& self, const Doubles& at, std::size_t n) {
            return nearest(self, Points(at, "points"), n);
          },
          py::arg("points"), py::arg("n") = 1);
}

}  // namespace

void bind_states(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(ComponentRow, label, volume, x, y, z, low_x, low_y, low_z, high_x, high_y, high_z);
  PYBIND11_NUMPY_DTYPE(HoleRow, radius, x, y, z);
  module.attr("status_names") = [] {
    py::list names;
    for (int i = 0; i <= static_cast<int>(SolveStatus::measured); ++i)
      names.append(std::string(name(static_cast<SolveStatus>(i))));
    return py::tuple(names);
  }();
  module.attr("label_names") = py::make_tuple("safe", "sparse", "gap", "blank");
  module.attr("state_dtype") = py::dtype::of<StateRow>();
  module.def("read_states", &read_states, py::arg("file"));
  module.def("write_states", &write_states, py::arg("file"), py::arg("states"), py::arg("spacing"));
  module.def(
      "measured",
      [](const Doubles& positions, const Doubles& forces, const std::optional<Doubles>& stiffness) {
        return array_of(states_of(positions, forces, stiffness));
      },
      py::arg("positions"), py::arg("forces"), py::arg("stiffness") = py::none());
  module.def("_stiffness_problem", [](const py::array_t<StateRow>& rows) {
    const std::vector<State> states = states_of(rows);
    const py::gil_scoped_release released;
    return disagreement_in_words(stiffness_agreement(states));
  });
  bind_thresholds(module);
  bind_space(module);
  module.def(
      "classify",
      [](const Doubles& positions, const Doubles& points, std::optional<double> spacing) {
        std::vector<State> states;
        for (const Vec3& at : points_of(positions, "positions")) {
          State& s = states.emplace_back();
          s.at = at;
          s.force = Vec3::Zero();
        }
        const Points at(points, "points");
        PySpace made;
        {
          const py::gil_scoped_release released;
          made = space_of(std::move(states), checked(spacing));
        }
        return labels(*made.space, at);
      },
      py::arg("positions"), py::arg("points"), py::arg("spacing") = py::none());
}

}  // namespace forefeel::python
