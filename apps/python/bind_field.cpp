// The field of jets at rest of a scene with contact.anywhere, for Python.

#include <omp.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "apps/python/arrays.hpp"
#include "apps/python/bindings.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel::python {
namespace {

struct PyField {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const DeepStates> known;
  int threads = 1;

  const RestSites& rest() const { return known->field().rest(); }
  SurfacePlace place(const Vec3& site, const char* argument) const {
    return place_at(rest(), site, argument);
  }
};

PyField make_field(const std::filesystem::path& file, const std::vector<std::string>& set,
                   const std::optional<std::filesystem::path>& states, int threads) {
  Globals globals;
  globals.quiet = true;
  globals.threads = threads > 0 ? threads : omp_get_max_threads();
  PyField made;
  made.threads = globals.threads;
  made.scene = std::make_shared<const Scene>(load_scene_with_sites(file, set, {.quiet = true}));
  if (!is_anywhere(*made.scene))
    throw InputError("scene", file.string() + ": its contact has a place, expected contact.anywhere = true");
  const std::shared_ptr<const SiteField> field = find_field(*made.scene, globals).field;
  std::vector<State> known;
  if (states) known = given_states(globals, *made.scene, states->string(), false).loaded.states;
  made.known = field_with(field, known, made.threads);
  return made;
}

// Sites and displacements of the same number, or one site for all.
std::vector<SitedPlace> places_of(const PyField& self, const Doubles& sites, const Doubles& displacements) {
  const Points s(sites, "sites"), x(displacements, "displacements");
  if (s.size() != x.size() && s.size() != 1)
    throw InputError(
        "sites", fmt::format("are {}, expected one, or as many as the {} displacements", s.size(), x.size()));
  std::vector<SitedPlace> places;
  for (std::size_t i = 0; i < x.size(); ++i)
    places.push_back({.site = self.place(s[s.size() == 1 ? 0 : i], "sites"), .x = x[i]});
  return places;
}

py::tuple evaluate_field(const PyField& self, const Doubles& sites, const Doubles& displacements) {
  const std::vector<SitedPlace> places = places_of(self, sites, displacements);
  const auto n = static_cast<py::ssize_t>(places.size());
  std::vector<Vec3> force(places.size()), at(places.size());
  py::array_t<double> stiffness({n, py::ssize_t{3}, py::ssize_t{3}}), energy(n), estimate(n), thickness(n);
  py::array_t<bool> trusted(n);
  double *k = stiffness.mutable_data(), *e = energy.mutable_data(), *error = estimate.mutable_data(),
         *thick = thickness.mutable_data();
  bool* good = trusted.mutable_data();
  {
    const py::gil_scoped_release released;
#pragma omp parallel for schedule(dynamic) num_threads(self.threads)
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SurfacePlace& place = places[i].site;
      const SiteModel model = self.known->field().at(place, false);
      const SiteTerms terms = self.known->at(model, place, places[i].x);
      const Vec3& normal = model.rest().normal;
      at[i] = place.at, force[i] = terms.force, e[i] = terms.energy;
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(k + 9 * i) = terms.stiffness;
      error[i] = self.known->estimated_error(model, place, places[i].x);
      thick[i] = self.rest().map().thickness(place, normal);
      good[i] = -places[i].x.dot(normal) <= thick[i] &&
                self.known->trusted(model, place, places[i].x, self.scene->spacing.tolerance,
                                    self.scene->session.judging.error_floor);
    }
  }
  return py::make_tuple(array_of(at), array_of(force), stiffness, energy, estimate, trusted, thickness);
}

py::array_t<StateRow> solve_in_field(const PyField& self, const Doubles& sites,
                                     const Doubles& displacements) {
  const std::vector<SitedPlace> places = places_of(self, sites, displacements);
  std::vector<State> states(places.size());
  {
    const py::gil_scoped_release released;
    solve_places(self.rest(), places, self.scene->space.spacing, self.threads,
                 [&](State state, std::size_t i) { states[i] = std::move(state); }, {});
  }
  return array_of(states);
}

// K(s) and the mean normal under the pad.
py::tuple rest_of(const PyField& self, const Doubles& sites) {
  const Points s(sites, "sites");
  const auto n = static_cast<py::ssize_t>(s.size());
  std::vector<SurfacePlace> places;
  for (std::size_t i = 0; i < s.size(); ++i) places.push_back(self.place(s[i], "sites"));
  std::vector<Vec3> normal(places.size());
  py::array_t<double> stiffness({n, py::ssize_t{3}, py::ssize_t{3}});
  double* k = stiffness.mutable_data();
  {
    const py::gil_scoped_release released;
#pragma omp parallel for schedule(dynamic) num_threads(self.threads)
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SiteRest rest = self.rest().at(places[i], false);
      normal[i] = rest.normal;
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(k + 9 * i) = rest.stiffness;
    }
  }
  return py::make_tuple(stiffness, array_of(normal));
}

}  // namespace

void bind_field(py::module_& module) {
  py::class_<PyField>(module, "SurfaceField")
      .def(py::init([](const std::filesystem::path& file, const std::vector<std::string>& set,
                       const std::optional<std::filesystem::path>& states, int threads) {
             const py::gil_scoped_release released;
             return make_field(file, set, states, threads);
           }),
           py::arg("scene"), py::arg("set"), py::arg("states"), py::arg("threads"))
      .def_property_readonly("sites",
                             [](const PyField& self) {
                               std::vector<Vec3> sites;
                               for (const FieldSite& site : self.known->field().sites())
                                 sites.push_back(site.place.at);
                               return array_of(sites);
                             })
      .def_property_readonly("depth", [](const PyField& self) { return self.scene->touch.anywhere->depth; })
      .def("_evaluate", &evaluate_field, py::arg("sites"), py::arg("displacements"))
      .def("_solve", &solve_in_field, py::arg("sites"), py::arg("displacements"))
      .def("_rest", &rest_of, py::arg("sites"));
}

}  // namespace forefeel::python
