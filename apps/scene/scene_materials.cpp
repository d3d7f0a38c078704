#include "apps/scene/scene_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "apps/scene/scene_declared.hpp"
#include "solver/body/material_limits.hpp"

namespace forefeel {
namespace {

Material read_material(const SceneTable& table, bool defaults) {
  std::vector<std::pair<std::string, Law>> words;
  for (const Law law : all_laws()) words.emplace_back(name(law), law);
  if (!defaults)
    for (const std::string key : {"law", "young", "poisson"})
      if (!table.has(key)) throw table.wrong(key, key == "law" ? "a material law" : "a number");
  Material material;
  material.law = table.word("law", words).value_or(material.law);
  material.young = table
                       .number("young", {softest_young, stiffest_young, false, false,
                                         "a number above 0, from 1e-3 to 1e15 [Pa]"})
                       .value_or(material.young);
  material.poisson =
      table.number("poisson", {-1, 0.5, true, true, "a number between -1 and 0.5, both excluded"})
          .value_or(material.poisson);
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
  for (const SceneTable& branch : material.subs("viscosity", keys_of("material.viscosity"))) {
    const auto share = branch.number("share", {0, 1, true, true, "a number between 0 and 1, both excluded"});
    const auto time = branch.number("time", {0, 1e9, true, false, "a number above 0 [s]"});
    if (!material.has("viscosity")) return {};
    if (!share) throw branch.wrong("share", "a number between 0 and 1, both excluded");
    if (!time) throw branch.wrong("time", "a number above 0 [s]");
    viscosity.push_back({*share, *time});
  }
  const std::string problem = problem_of(viscosity);
  if (!problem.empty()) throw InputError(material.where("viscosity"), "has " + problem);
  return viscosity;
}

}  // namespace

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
