#include <fmt/format.h>
#include <omp.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "apps/python/bindings.hpp"
#include "apps/python/scene_object.hpp"
#include "geometry/common/error.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/states/energy_jet.hpp"
#include "solver/body/pad.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel::python {

namespace {

// Long calls that show progress and can be stopped by Ctrl-C. Python handles signals on its main thread only, so the
// work runs on another thread while the calling thread watches.

using ShowShare = std::function<void(double)>;  // of the work that is done, 0 to 1

// Runs work(stop, tell) without the interpreter's lock; tell(share) may be called on any thread. Calls
// show(share) up to 20 times a second on the calling thread. A signal or an exception of show() requests the stop; the
// exception is rethrown when the work has ended. Exceptions of the work are rethrown, too.
void run_interruptibly(const ShowShare& show,
                       const std::function<void(std::stop_token, const std::function<void(double)>&)>& work);

namespace py = pybind11;

void run_interruptibly(const ShowShare& show,
                       const std::function<void(std::stop_token, const std::function<void(double)>&)>& work) {
  std::atomic<double> share = 0;
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr of_work, of_watch;
  const py::gil_scoped_release released;
  std::jthread worker([&](std::stop_token stop) {
    try {
      work(stop, [&](double now) { share = now; });
    } catch (...) {
      of_work = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_one();
  });
  double shown = -1;
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return done; })) {
    lock.unlock();
    if (!of_watch) try {
        const py::gil_scoped_acquire locked;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        const double now = share;
        if (show && now != shown) show(shown = now);
      } catch (...) {
        of_watch = std::current_exception();
        worker.request_stop();
      }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (of_watch) std::rethrow_exception(of_watch);
  if (of_work) std::rethrow_exception(of_work);
  if (show) {
    const py::gil_scoped_acquire locked;
    show(1);
  }
}

using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::vector<NodeIndex> node_set(const Integers& given, std::size_t nodes, const char* argument) {
  std::vector<NodeIndex> set;
  for (const std::int64_t node : std::span(given.data(), static_cast<std::size_t>(given.size()))) {
    if (node < 0 || node >= static_cast<std::int64_t>(nodes))
      throw InputError(argument, fmt::format("holds node {}, expected 0 to {}", node, nodes - 1));
    set.push_back(static_cast<NodeIndex>(node));
  }
  std::ranges::sort(set);
  set.erase(std::unique(set.begin(), set.end()), set.end());
  return set;
}

// None, or a dict with nearest, radius and stiffness; only nearest is required.
std::optional<Pad> pad_of(const py::object& given, const TetMesh& mesh) {
  if (given.is_none()) return {};
  const auto keys =
      cast_to<std::map<std::string, py::object>>(given, "pad", "a dict with nearest, radius, stiffness");
  for (const auto& [key, value] : keys)
    if (key != "nearest" && key != "radius" && key != "stiffness")
      throw InputError("pad", fmt::format("has '{:.40}', expected nearest, radius, stiffness", key));
  if (!keys.contains("nearest"))
    throw InputError("pad.nearest", "missing, expected (x, y, z), the place of the pad on the mesh [m]");
  const Doubles place = Doubles::ensure(keys.at("nearest"));
  if (!place || place.size() != 3)
    throw InputError("pad.nearest", fmt::format("is {:.60}, expected three numbers [m]",
                                                std::string(py::repr(keys.at("nearest")))));
  const Vec3 nearest = points_of(place, "pad.nearest").front();
  const double far =
      100 * longest_side(mesh);  // as in a scene: such a place is a slip, millimetres for metres
  if (const Box box = bounding_box(mesh);
      ((nearest - box.low).array() < -far || (nearest - box.high).array() > far).any())
    throw InputError("pad.nearest", "is far from the body, expected a place near it in metres");
  Pad pad{.site = nearest_site(mesh, nearest)};
  const auto read = [&](const char* key, const char* unit, double& to) {
    if (!keys.contains(key)) return;
    const std::string argument = std::string("pad.") + key;
    to = cast_to<double>(keys.at(key), argument, "a number");
    if (!(to > 0 && std::isfinite(to)))
      throw InputError(argument, fmt::format("is {} {}, expected a number above 0", to, unit));
  };
  read("radius", "m", pad.radius);
  read("stiffness", "N/m", pad.stiffness);
  return pad;
}

py::object dict_of(const std::optional<Pad>& pad) {
  if (!pad) return py::none();
  py::dict out;
  out["nearest"] = array_of(pad->site);
  out["radius"] = pad->radius;
  out["stiffness"] = pad->stiffness;
  return out;
}

PyBody make_body(const Doubles& nodes, const Integers& tets, const Integers& clamp, const Integers& contact,
                 const std::string& law, double young, double poisson, const std::string& element,
                 const py::object& pad) {
  auto body = std::make_shared<Body>();
  body->mesh.nodes = points_of(nodes, "nodes");
  if (tets.ndim() != 2 || tets.shape(1) != 4)
    throw InputError("tets", "expected the shape (t, 4): numbers of nodes, from 0");
  const std::size_t count = body->mesh.nodes.size();
  for (py::ssize_t t = 0; t < tets.shape(0); ++t) {
    Tet& tet = body->mesh.tets.emplace_back();
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int64_t node = tets.data()[4 * t + static_cast<py::ssize_t>(i)];
      if (node < 0 || node >= static_cast<std::int64_t>(count))
        throw InputError("tets",
                         fmt::format("row {} (from 0) holds node {}, expected 0 to {}", t, node, count - 1));
      tet[i] = static_cast<NodeIndex>(node);
    }
  }
  body->material.law = chosen(law, "law", all_laws());
  body->material.young = young;
  body->material.poisson = poisson;
  body->clamp = node_set(clamp, count, "clamp");
  body->contact = node_set(contact, count, "contact");
  body->element = chosen(element, "element", std::array{Element::linear, Element::quadratic});
  std::vector<std::string> warnings = check_and_orient(body->mesh, "Body").warnings;
  const std::vector<char> used = used_nodes(body->mesh);
  for (auto* set : {&body->clamp, &body->contact})
    std::erase_if(*set, [&](NodeIndex node) { return !used[node]; });
  body->pad = pad_of(pad, body->mesh);
  if (body->pad && !body->contact.empty())
    throw InputError("contact", "names nodes beside pad, expected none: its place is pad['nearest']");
  for (std::string& warning : check(*body, "Body")) warnings.push_back(std::move(warning));
  return {std::move(body), std::move(warnings)};
}

py::array_t<std::int32_t> tets_of(const TetMesh& mesh) {
  py::array_t<std::int32_t> tets({static_cast<py::ssize_t>(mesh.tets.size()), py::ssize_t{4}});
  std::int32_t* to = tets.mutable_data();
  for (const Tet& tet : mesh.tets) to = std::ranges::copy(tet, to).out;
  return tets;
}

py::array_t<std::int32_t> indices(const std::vector<NodeIndex>& nodes) {
  py::array_t<std::int32_t> array(static_cast<py::ssize_t>(nodes.size()));
  std::ranges::copy(nodes, array.mutable_data());
  return array;
}

// As `forefeel solve`: each state on the reference branch, and whether another path ends elsewhere.
std::vector<State> solve_all(const std::shared_ptr<const Body>& body, const std::vector<Vec3>& at,
                             double spacing, const SolveOptions& options, const ShowShare& progress) {
  std::vector<State> states(at.size());
  run_interruptibly(progress, [&](const std::stop_token& stop, const std::function<void(double)>& tell) {
    const int threads = std::min(omp_get_max_threads(), std::max(1, static_cast<int>(at.size())));
    std::atomic<std::size_t> done = 0;
#pragma omp parallel num_threads(threads)
    {
      Solver solver(body);
#pragma omp for schedule(dynamic)
      for (std::size_t i = 0; i < at.size(); ++i) {
        if (stop.stop_requested()) continue;
        states[i] = solver.reference(at[i], spacing, options).state;
        states[i].solve.multivalued = second_way_differs(solver, states[i], spacing);
        tell(static_cast<double>(++done) / static_cast<double>(at.size()));
      }
    }
  });
  return states;
}

// (v, 3) of each state: (n, v, 3).
py::array_t<double> displacements_of(std::span<const State> states, std::size_t nodes) {
  const auto rows = static_cast<py::ssize_t>(nodes);
  py::array_t<double> u({static_cast<py::ssize_t>(states.size()), rows, py::ssize_t{3}});
  std::fill_n(u.mutable_data(), u.size(), unknown);
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states[i].displacements)
      std::ranges::copy(std::span(*states[i].displacements).first(3 * nodes),
                        u.mutable_data() + 3 * rows * static_cast<py::ssize_t>(i));
  return u;
}

// The array alone, or a tuple of it and what else is wanted.
py::object solve(const PyBody& self, const Doubles& positions, double spacing, bool displacements,
                 const ShowShare& progress, int jet) {
  check_spacing(spacing);
  if (jet < 1 || jet > most_jet_order)
    throw InputError("jet",
                     fmt::format("is {}, expected 1 to {}: the order of the force", jet, most_jet_order));
  const std::vector<Vec3> at = points_of(positions, "positions");
  const double farthest = 100 * longest_side(self.body->mesh);  // as `forefeel solve`
  for (std::size_t i = 0; i < at.size(); ++i)
    if (!(at[i].cwiseAbs().maxCoeff() <= farthest))
      throw InputError("positions",
                       fmt::format("row {} (from 0) is farther from rest than {:.3g} m, 100 times the "
                                   "body's longest side; expected metres",
                                   i, farthest));
  const std::vector<State> states =
      solve_all(self.body, at, spacing, {.want_displacements = displacements, .jet = jet}, progress);
  if (!displacements && jet == 1) return array_of(states);
  py::list parts;
  parts.append(array_of(states));
  if (displacements) parts.append(displacements_of(states, self.body->mesh.nodes.size()));
  if (jet > 1) parts.append(jets_of(states));
  return py::tuple(parts);
}

py::array_t<StateRow> generate(const PyBody& self, double spacing, const Doubles& box, int threads,
                               const ShowShare& progress) {
  const std::vector<Vec3> corners = points_of(box, "box");
  if (corners.size() != 2 || (corners[0].array() > corners[1].array()).any())
    throw InputError("box", "expected the shape (2, 3): low corner, high corner");
  check_spacing(spacing);
  if (!((corners[1] - corners[0]).array() / spacing + 1).isFinite().all() ||
      ((corners[1] - corners[0]).array() / spacing + 1).prod() > 1e8)
    throw InputError("spacing", "gives more than 1e8 positions in the box, expected a larger one");
  std::vector<State> states;
  run_interruptibly(progress, [&](const std::stop_token& stop, const std::function<void(double)>& tell) {
    LatticeOptions options;
    options.spacing = spacing;
    options.box = {corners[0], corners[1]};
    options.threads = threads;
    options.stop = stop;
    generate_lattice(
        self.body, options, [&](State state) { states.push_back(std::move(state)); },
        [&](std::size_t done, std::size_t total) {
          tell(static_cast<double>(done) / static_cast<double>(total));
        });
  });
  // By position, so that the order does not depend on the threads.
  std::ranges::sort(states, [](const State& a, const State& b) {
    return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
  return array_of(states);
}

py::dict mesh_dict(const TetMesh& mesh) {
  py::dict out, groups;
  out["nodes"] = array_of(mesh.nodes);
  out["tets"] = tets_of(mesh);
  for (const auto& [group, nodes] : mesh.groups) groups[py::str(group)] = indices(nodes);
  out["groups"] = groups;
  return out;
}

}  // namespace

void bind_body(py::module_& module) {
  py::class_<PyBody>(module, "Body")
      .def(py::init(&make_body), py::arg("nodes"), py::arg("tets"), py::arg("clamp"), py::arg("contact"),
           py::arg("law"), py::arg("young"), py::arg("poisson"), py::arg("element"),
           py::arg("pad") = py::none())
      .def_property_readonly("nodes", [](const PyBody& self) { return array_of(self.body->mesh.nodes); })
      .def_property_readonly("tets", [](const PyBody& self) { return tets_of(self.body->mesh); })
      .def_property_readonly("clamp", [](const PyBody& self) { return indices(self.body->clamp); })
      .def_property_readonly("contact", [](const PyBody& self) { return indices(self.body->contact); })
      .def_property_readonly("pad", [](const PyBody& self) { return dict_of(self.body->pad); })
      .def_property_readonly("warnings", [](const PyBody& self) { return self.warnings; })
      .def("solve", &solve, py::arg("positions"), py::arg("spacing"), py::arg("displacements"),
           py::arg("progress"), py::arg("jet") = 1)
      .def("generate", &generate, py::arg("spacing"), py::arg("box"), py::arg("threads"),
           py::arg("progress"));
  module.def("read_mesh", [](const std::filesystem::path& file) {
    TetMesh mesh;
    {
      const py::gil_scoped_release released;
      mesh = read_mesh(file);
    }
    return mesh_dict(mesh);
  });
}

}  // namespace forefeel::python
