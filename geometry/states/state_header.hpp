#pragma once
// What a state file holds beside its states: what they belong to, their spacing and box, notes.

#include <map>
#include <string>

#include "geometry/states/state.hpp"

namespace forefeel {

// The identity of the body that a set of states belongs to: mesh, element, material, clamp and contact, each as a
// hash or in words. identity_of(body) in solver/body/body_digest.hpp makes it. Measured states have none.
using BodyIdentity =
    std::map<std::string, std::string>;  // "mesh" -> "sha256 …", "material" -> "neo-hookean, …"

// InputError that names the file and each key that differs, if both identities are known and differ.
void check_same_body(const std::string& file, const BodyIdentity& in_file, const BodyIdentity& ours);
// The keys that differ, each with both values: "material (file …, here …)"; empty where none does.
std::string differing_keys(const BodyIdentity& in_file, const BodyIdentity& ours);

struct StateFileHeader {
  BodyIdentity identity;
  double spacing = unknown;  // [m]
  Box box;
  std::map<std::string, std::string> notes;  // provenance, free text
};

}  // namespace forefeel
