#pragma once
// A body: mesh [m], one or several materials, clamped nodes (fixed boundary, u = 0), and a contact with the HIP (haptic
// interaction point, the tip of the device) at x [m], zero at the rest position of the contact. The contact is a rigid
// patch, nodes that are bound to the HIP in both directions (u = x), or a compliant pad, springs between surface and
// HIP.

#include <memory>
#include <optional>
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

// Tetrahedra of another material than the rest of the body: a tumour, a vessel, a bone.
struct MaterialRegion {
  std::string name;
  Material material;
  std::vector<TetIndex> tets;  // sorted, not empty; no tetrahedron is in two regions
};

class FineJet;      // fine_jet.hpp
struct PadSurface;  // pad.hpp

// A compliant pad; its equations are in pad.hpp.
struct Pad {
  Vec3 site = Vec3::Zero();  // s, on the surface [m]
  double radius = 0.02;      // r [m]
  double stiffness = 1000;   // k_p [N/m]
  friend bool operator==(const Pad&, const Pad&) = default;
};

struct Body {
  TetMesh mesh;
  Material material;               // of all tetrahedra outside the regions
  std::vector<NodeIndex> clamp;    // sorted, not empty
  std::vector<NodeIndex> contact;  // sorted, disjoint from clamp; empty with a pad, and only then
  Element element = Element::linear;
  std::vector<MaterialRegion> regions = {};
  std::optional<Pad> pad = {};
  std::shared_ptr<const FineJet> fine = {};  // added to what the body answers; null: none
};

// Throws InputError(file: key) for a body that cannot be solved: empty or out-of-range node sets, contact on
// a clamped node, a connected part without a clamped node, E <= 0, nu outside (-1, 0.5), a tetrahedron in two
// regions. Returns warnings (nu > 0.45 locks …).
std::vector<std::string> check(const Body& body, const std::string& file);

// One material and all tetrahedra that have it, ascending.
struct MaterialPart {
  Material material;
  std::vector<TetIndex> tets;
};
// The distinct materials of the body in the order of their first tetrahedra; regions of equal material are one
// part. What is computed from the parts does not depend on the regions' names and order.
std::vector<MaterialPart> material_parts(const Body& body);
bool has_rest(const Body& body);                    // a tetrahedron is in no region
std::vector<Material> materials(const Body& body);  // that at least one tetrahedron has

// Where the HIP is at rest: the pad's site, or the mean of the contact nodes [m].
Vec3 rest_of_contact(const Body& body);
// Share of the springs (of linear elements) that clamped nodes carry, 0 to 1.
double clamped_share(const Body& body, const PadSurface& surface);

// True if f = -K x exactly: one factorisation then gives every state.
bool is_linear(const Body& body);

}  // namespace forefeel
