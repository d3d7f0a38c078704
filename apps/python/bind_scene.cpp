#include <omp.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <memory>

#include "apps/python/bindings.hpp"
#include "apps/python/scene_object.hpp"
#include "apps/scene_input/scene_session.hpp"
#include "geometry/common/error.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel::python {
namespace {

using ShowShare = std::function<void(double)>;

// Shows progress and heeds Ctrl-C. Called without the interpreter's lock; false asks the caller to stop.
bool keep_on(const ShowShare& show, double share) {
  const py::gil_scoped_acquire locked;
  if (PyErr_CheckSignals() != 0) return false;
  if (show) show(share);
  return true;
}

py::dict solve(const PyScene& self, const Doubles& positions, bool displacements) {
  const std::vector<Vec3> at = points_of(positions, "positions");
  const Scene& scene = *self.scene;
  std::vector<State> states(at.size());
  {
    const py::gil_scoped_release released;
    const int threads = std::min(omp_get_max_threads(), std::max(1, static_cast<int>(at.size())));
#pragma omp parallel num_threads(threads)
    {
      Solver solver(scene.body);
#pragma omp for schedule(dynamic)
      for (std::size_t i = 0; i < at.size(); ++i) {
        states[i] = solver.reference(at[i], scene.space.spacing, {.want_displacements = displacements}).state;
        states[i].multivalued = second_way_differs(solver, states[i], scene.space.spacing);
      }
    }
  }
  py::dict out;
  out["states"] = array_of(states);
  if (displacements) {
    const auto nodes = static_cast<py::ssize_t>(scene.body->mesh.nodes.size());
    py::array_t<double> u({static_cast<py::ssize_t>(at.size()), nodes, py::ssize_t{3}});
    std::fill_n(u.mutable_data(), u.size(), unknown);
    for (std::size_t i = 0; i < at.size(); ++i)
      if (states[i].displacements)
        std::ranges::copy(std::span(*states[i].displacements).first(static_cast<std::size_t>(3 * nodes)),
                          u.mutable_data() + 3 * nodes * static_cast<py::ssize_t>(i));
    out["displacements"] = u;
  }
  return out;
}

py::array_t<StateRow> generate(const PyScene& self, std::optional<double> spacing, int threads,
                               const ShowShare& progress) {
  const Scene& scene = *self.scene;
  const StateSpaceOptions space = spacing ? space_at(scene, *spacing) : scene.space;
  std::vector<State> states;
  bool stopped = false;
  {
    const py::gil_scoped_release released;
    std::stop_source stop;
    GenerateOptions options;
    options.spacing = space.spacing;
    options.box = space.box;
    options.threads = threads;
    options.stop = stop.get_token();
    generate_lattice(
        scene.body, options, {}, [&](State state) { states.push_back(std::move(state)); },
        [&](std::size_t done, std::size_t total) {
          if (stopped || keep_on(progress, double(done) / double(total))) return;
          stopped = true;
          stop.request_stop();
        });
  }
  if (stopped) throw py::error_already_set();
  // By position, so that the order does not depend on the threads.
  std::ranges::sort(states, [](const State& a, const State& b) {
    return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
  return array_of(states);
}

py::dict body(const PyScene& self) {
  const Body& b = *self.scene->body;
  py::dict out;
  out["nodes"] = array_of(b.mesh.nodes);
  py::array_t<std::int32_t> tets({static_cast<py::ssize_t>(b.mesh.tets.size()), py::ssize_t{4}});
  std::int32_t* to = tets.mutable_data();
  for (const Tet& tet : b.mesh.tets) to = std::ranges::copy(tet, to).out;
  out["tets"] = tets;
  const auto indices = [](const std::vector<NodeIndex>& nodes) {
    return py::array_t<std::int32_t>(static_cast<py::ssize_t>(nodes.size()), nodes.data());
  };
  out["clamp"] = indices(b.clamp);
  out["contact"] = indices(b.contact);
  return out;
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<PyScene>(module, "Scene")
      .def(py::init([](const std::filesystem::path& file, const std::vector<std::string>& set) {
             const py::gil_scoped_release released;
             return PyScene{std::make_shared<const Scene>(load_scene(file, set))};
           }),
           py::arg("file"), py::arg("set") = std::vector<std::string>{})
      .def_property_readonly("file", [](const PyScene& self) { return self.scene->file.string(); })
      .def_property_readonly("spacing", [](const PyScene& self) { return self.scene->space.spacing; })
      .def_property_readonly("box",
                             [](const PyScene& self) {
                               const Vec3 corners[] = {self.scene->space.box.low, self.scene->space.box.high};
                               return array_of(corners);
                             })
      .def_property_readonly("warnings", [](const PyScene& self) { return self.scene->warnings; })
      .def_property_readonly("identity",
                             [](const PyScene& self) {
                               return std::map<std::string, std::string>(self.scene->identity.begin(),
                                                                         self.scene->identity.end());
                             })
      .def("_body", &body)
      .def("_solve", &solve, py::arg("positions"), py::arg("displacements"))
      .def("_generate", &generate, py::arg("spacing"), py::arg("threads"), py::arg("progress"));
}

}  // namespace forefeel::python
