#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <memory>
#include <optional>

#include "apps/python/bindings.hpp"
#include "apps/python/scene_object.hpp"
#include "apps/scene/scene_anywhere.hpp"

namespace forefeel::python {
namespace {

// InputError for a scene without a place of contact.
const Scene& with_a_place(const PyScene& self) {
  if (is_anywhere(*self.scene))
    throw InputError("scene",
                     "has contact.anywhere: for its sessions and SurfaceField, expected a place of contact");
  return *self.scene;
}

// The lattice of a scene, with another spacing if one is given [m]: spacing and box.
py::tuple lattice_of(const PyScene& self, std::optional<double> spacing) {
  if (spacing) check_spacing(*spacing);
  const Scene& scene = with_a_place(self);
  const StateSpaceOptions space = spacing ? space_at(scene, *spacing) : scene.space;
  return py::make_tuple(space.spacing, array_of(space.box));
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<PyScene>(module, "Scene")
      .def(py::init([](const std::filesystem::path& file, const std::vector<std::string>& set) {
             const py::gil_scoped_release released;
             return PyScene{std::make_shared<const Scene>(load_scene_with_sites(file, set, {}))};
           }),
           py::arg("file"), py::arg("set") = std::vector<std::string>{})
      .def_property_readonly("file", [](const PyScene& self) { return self.scene->source.file.string(); })
      .def_property_readonly("spacing", [](const PyScene& self) { return self.scene->space.spacing; })
      .def_property_readonly("box", [](const PyScene& self) { return array_of(self.scene->space.box); })
      .def_property_readonly("warnings", [](const PyScene& self) { return self.scene->source.warnings; })
      .def_property_readonly("identity",
                             [](const PyScene& self) {
                               return std::map<std::string, std::string>(self.scene->identity.begin(),
                                                                         self.scene->identity.end());
                             })
      .def("_body", [](const PyScene& self) { return PyBody{with_a_place(self).body}; })
      .def("_lattice", &lattice_of, py::arg("spacing"));
}

}  // namespace forefeel::python
