#include "apps/scene/scene_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "apps/scene/scene_declared.hpp"
#include "solver/body/material.hpp"

namespace forefeel {
namespace {

const SceneRows<MaxwellBranch>& branch_rows() {
  using B = MaxwellBranch;
  static const auto rows =
      SceneRows<B>(
          "material.viscosity",
          "[[material.viscosity]]: a branch of a generalised Maxwell material. The law gives the force "
          "of a fast press; while the tip is held, it relaxes to (1 - sum of the shares) times that "
          "force.")
          .number("share", "1", {0, 1, true, true, "a number between 0 and 1, both excluded"},
                  "share of the force that relaxes, between 0 and 1; their sum is below 1", &B::share)
          .required("a number between 0 and 1, both excluded")
          .number("time", "s", {0, 1e9, true, false, "a number above 0 [s]"},
                  "relaxation time, in which that share falls to 37 %", &B::time)
          .required("a number above 0 [s]");
  return rows;
}

const SceneRows<Material>& rows_of_material() {
  using M = Material;
  static const auto rows =
      SceneRows<M>(
          "material",
          "The law of the tissue. For several tissues: [[material]] tables, each with a group, and one "
          "without.")
          .row({"group", "", "",
                "name of a group of tetrahedra of the mesh; without it, the table is for the rest"})
          .word("law", law_words, "", &M::law)
          .required_with_mesh("a material law")
          .number("young", "Pa",
                  {softest_young, stiffest_young, false, false, "a number above 0, from 1e-3 to 1e15 [Pa]"},
                  "Young's modulus at small strain, of every law: at rest its stiffness is that of the "
                  "linear law",
                  &M::young)
          .required_with_mesh("a number")
          .number("poisson", "1", {-1, 0.5, true, true, "a number between -1 and 0.5, both excluded"},
                  "Poisson's ratio at small strain, of every law, between -1 and 0.5", &M::poisson)
          .required_with_mesh("a number")
          .row({"viscosity", "", "",
                "[[material.viscosity]] tables: the tissue relaxes; the same for all materials"})
          .within(branch_rows());
  return rows;
}

Material read_material(const SceneTable& table, bool defaults) {
  if (!defaults) rows_of_material().check_required(table);
  Material material;
  rows_of_material().read(table, material);
  return material;
}

const std::vector<TetIndex>& tets_of(const MaterialTable& of, const TetMesh& mesh) {
  if (mesh.element_groups.empty())
    throw of.table.wrong(
        "group",
        "a group of tetrahedra, but the mesh names none: it would be a physical volume of .msh, "
        "a label in a cell array of .vtk or .vtu, or a reference of .mesh");
  std::vector<std::string> names;
  for (const auto& [name, tets] : mesh.element_groups) names.push_back(name);
  return mesh.element_groups.at(names[chosen_word(of.table, "group", of.group, names)]);
}

// The [[material.viscosity]] tables of one material.
Viscosity viscosity_of(const SceneTable& material) {
  Viscosity viscosity;
  for (const SceneTable& branch : material.subs("viscosity", branch_rows().names())) {
    branch_rows().read(branch, viscosity.emplace_back());
    if (!material.has("viscosity")) return {};
    branch_rows().check_required(branch);
  }
  const std::string problem = problem_of(viscosity);
  if (!problem.empty()) throw InputError(material.where("viscosity"), "has " + problem);
  return viscosity;
}

}  // namespace

const SceneRowList& material_rows() {
  return rows_of_material();
}

Viscosity read_viscosity(const std::vector<SceneTable>& tables) {
  const Viscosity first = viscosity_of(tables.front());
  for (const SceneTable& table : tables)
    if (viscosity_of(table) != first)
      throw InputError(table.where("viscosity"),
                       "differs from that of the first [[material]], expected the same in every table: the "
                       "force at the tip has one relaxation function");
  return first;
}

std::vector<MaterialTable> read_materials(const std::vector<SceneTable>& tables, bool defaults) {
  std::vector<MaterialTable> read;
  for (const SceneTable& table : tables) {
    const std::string group = table.text("group").value_or("");
    if (std::ranges::find(read, group, &MaterialTable::group) != read.end())
      throw InputError(table.place(), group.empty()
                                          ? "a second table without a group, expected at most one"
                                          : fmt::format("a second table of group '{}', expected one", group));
    read.push_back({table, group, read_material(table, defaults)});
  }
  return read;
}

void assign_materials(const std::vector<MaterialTable>& tables, Body& body,
                      std::vector<std::string>& warnings) {
  std::vector<const MaterialTable*> of(body.mesh.tets.size(), nullptr);
  const MaterialTable* rest = nullptr;
  for (const MaterialTable& table : tables) {
    if (table.group.empty()) {
      rest = &table;
      continue;
    }
    const std::vector<TetIndex>& tets = tets_of(table, body.mesh);
    for (const TetIndex tet : tets) {
      const MaterialTable*& its = of[tet];
      if (its)
        throw table.table.wrong(
            "group", fmt::format("a group apart from '{}': tetrahedron {} is in both", its->group, tet));
      its = &table;
    }
    body.regions.push_back({table.group, table.material, tets});
  }
  body.material = rest ? rest->material : tables.front().material;
  const auto left = std::ranges::count(of, nullptr);
  if (!rest && left > 0)
    throw InputError(tables.front().table.place(),
                     fmt::format("{} of the {} tetrahedra are in none of the groups, expected a [[material]] "
                                 "without a group for them",
                                 left, of.size()));
  if (rest && left == 0)
    warnings.push_back(rest->table.place().text() +
                       ": without effect, since all tetrahedra are in the groups of the other tables");
}

}  // namespace forefeel
