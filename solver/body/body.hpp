#pragma once
// A body: mesh, hyperelastic law, clamped nodes, and contact nodes that translate rigidly with the HIP by x.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"
#include "solver/body/material.hpp"

namespace forefeel {

// linear: four-node tetrahedra, one point. quadratic: ten-node tetrahedra (straight edges, four points) on the same
// mesh, which do not lock above nu = 0.45.
enum class Element { linear, quadratic };
std::string_view name(Element element);  // "linear", "quadratic"
std::vector<std::string> element_names();

struct Body {
  TetMesh mesh;
  Material material;
  std::vector<NodeIndex> clamp;    // sorted, not empty
  std::vector<NodeIndex> contact;  // sorted, not empty, disjoint from clamp
  Element element = Element::linear;
};

// Throws InputError(file: key) for what cannot be solved: empty or out-of-range node sets, contact on a clamped
// node, a connected part without a clamped node, E <= 0, nu outside (-1, 0.5). Returns warnings (nu > 0.45 locks …).
std::vector<std::string> check(const Body& body, const std::string& file);

// True where f = -K x exactly: one factorisation gives every state.
bool is_linear(const Body& body);

}  // namespace forefeel
