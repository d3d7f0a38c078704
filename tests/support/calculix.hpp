#pragma once
// CalculiX as an oracle: a body as an input deck, and the force that it finds. *ELASTIC is the linear law, with NLGEOM
// it is St. Venant-Kirchhoff. Several materials: one set of elements each.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "solver/body/body.hpp"

namespace forefeel::test {

// Corners and mid-edge nodes in the order of C3D10; of linear elements, only the corners.
struct CalculixMesh {
  std::vector<Vec3> nodes;
  std::vector<std::vector<int>> elements;
  std::vector<NodeIndex> clamp, contact;

  explicit CalculixMesh(const Body& body) : nodes(body.mesh.nodes), clamp(body.clamp), contact(body.contact) {
    const std::set<NodeIndex> held(clamp.begin(), clamp.end()), touched(contact.begin(), contact.end());
    std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> middles;
    for (const Tet& tet : body.mesh.tets) {
      std::vector<int> nodes_of(tet.begin(), tet.end());
      constexpr std::size_t edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
      for (const auto& [i, j] : edges) {
        if (body.element == Element::linear) break;
        const auto ends = std::minmax(tet[i], tet[j]);
        const auto [at, is_new] = middles.emplace(ends, static_cast<NodeIndex>(nodes.size()));
        nodes_of.push_back(at->second);
        if (!is_new) continue;
        nodes.push_back(0.5 * (body.mesh.nodes[static_cast<std::size_t>(ends.first)] +
                               body.mesh.nodes[static_cast<std::size_t>(ends.second)]));
        if (held.contains(ends.first) && held.contains(ends.second)) clamp.push_back(at->second);
        if (touched.contains(ends.first) && touched.contains(ends.second)) contact.push_back(at->second);
      }
      elements.push_back(nodes_of);
    }
  }
};

inline void write_elements(std::ostream& deck, const Body& body, const CalculixMesh& mesh) {
  const char* type = body.element == Element::linear ? "C3D4" : "C3D10";
  int part = 0;
  for (const MaterialPart& of : material_parts(body)) {
    deck << fmt::format("*ELEMENT, TYPE={}, ELSET=E{}\n", type, ++part);
    for (const TetIndex tet : of.tets)
      deck << fmt::format("{}, {}\n", tet + 1, [&] {
        std::string text;
        for (const int node : mesh.elements[static_cast<std::size_t>(tet)])
          text += (text.empty() ? "" : ", ") + std::to_string(node + 1);
        return text;
      }());
    deck << fmt::format(
        "*MATERIAL, NAME=M{0}\n*ELASTIC\n{1:.12e}, {2:.12e}\n*SOLID SECTION, ELSET=E{0}, MATERIAL=M{0}\n",
        part, of.material.young, of.material.poisson);
  }
}

inline void write_deck(const std::filesystem::path& file, const Body& body, const Vec3& x, bool nonlinear) {
  const CalculixMesh mesh(body);
  std::ofstream deck(file);
  deck << "*NODE, NSET=ALL\n";
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    deck << fmt::format("{}, {:.12e}, {:.12e}, {:.12e}\n", i + 1, mesh.nodes[i][0], mesh.nodes[i][1],
                        mesh.nodes[i][2]);
  write_elements(deck, body, mesh);
  const auto set = [&](const char* set_name, const std::vector<NodeIndex>& nodes) {
    deck << "*NSET, NSET=" << set_name << "\n";
    for (const NodeIndex node : nodes) deck << node + 1 << ",\n";
  };
  set("CLAMP", mesh.clamp);
  set("CONTACT", mesh.contact);
  deck << "*BOUNDARY\nCLAMP, 1, 3\n";
  deck << (nonlinear ? "*STEP, NLGEOM, INC=200\n*STATIC\n0.1, 1.\n" : "*STEP\n*STATIC\n");
  if (nonlinear) deck << "*CONTROLS, PARAMETERS=FIELD\n1e-9, 1e-9\n";
  deck << "*BOUNDARY\n";
  for (int i = 0; i < 3; ++i) deck << fmt::format("CONTACT, {}, {}, {:.12e}\n", i + 1, i + 1, x[i]);
  deck << "*NODE PRINT, NSET=CONTACT, TOTALS=ONLY, FREQUENCY=200\nRF\n*END STEP\n";
}

// The total reaction on the contact that is printed last.
inline Vec3 read_total(const std::filesystem::path& file) {
  std::ifstream data(file);
  Vec3 total = Vec3::Constant(std::nan(""));
  for (std::string line; std::getline(data, line);) {
    if (line.find("total force") == std::string::npos) continue;
    std::string values;
    while (std::getline(data, values) && values.find_first_not_of(" \r\t") == std::string::npos) {
    }
    std::istringstream(values) >> total[0] >> total[1] >> total[2];
  }
  return total;
}

// The body's force on the HIP at x [N], to the 7 digits that CalculiX prints; NaN where it fails.
inline Vec3 calculix_force(const std::filesystem::path& folder, const Body& body, const Vec3& x,
                           bool nonlinear) {
  write_deck(folder / "body.inp", body, x, nonlinear);
  const std::string command =
      "cd '" + folder.string() + "' && OMP_NUM_THREADS=1 CCX_NPROC_STIFFNESS=1 ccx body > body.log 2>&1";
  if (std::system(command.c_str()) != 0) return Vec3::Constant(std::nan(""));
  return -read_total(folder / "body.dat");  // it prints the force on the body
}

}  // namespace forefeel::test
