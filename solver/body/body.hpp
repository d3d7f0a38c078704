#pragma once
// A body: mesh [m], material, clamped nodes (u = 0), and contact nodes that move with the HIP (u = x, a
// translation). HIP: haptic interaction point, the tip of the device; x [m] counts from the rest position of
// the contact.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"
#include "solver/body/material.hpp"

namespace forefeel {

// linear: four-node tetrahedra, one integration point; they lock (answer too stiffly) above nu = 0.45.
// quadratic: ten-node tetrahedra on the same mesh (straight edges, four integration points); they do not.
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

// Throws InputError(file: key) for a body that cannot be solved: empty or out-of-range node sets, contact on
// a clamped node, a connected part without a clamped node, E <= 0, nu outside (-1, 0.5). Returns warnings (nu
// > 0.45 locks …).
std::vector<std::string> check(const Body& body, const std::string& file);

// True if f = -K x exactly: one factorisation then gives every state.
bool is_linear(const Body& body);

}  // namespace forefeel
