#pragma once
// Bodies that are touched through a compliant pad.

#include <algorithm>
#include <memory>
#include <string>

#include "block_body.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/body/pad.hpp"

namespace forefeel {

// The block of block_body() with a pad in the middle of its long upper side.
inline std::shared_ptr<Body> padded_block(Law law, Element element = Element::linear, double poisson = 0.4) {
  const auto body = block_body(law, poisson, 1, element);
  body->contact.clear();
  body->pad = Pad{.site = Vec3(0.07, 0.021, 0.04), .radius = 0.015, .stiffness = 800};
  return body;
}

// A phantom with its own clamp, and a pad at the point of its surface that is nearest to `place`.
inline std::shared_ptr<Body> padded_phantom(const std::string& name, std::size_t elements, const Vec3& place,
                                            Law law = Law::neo_hookean, Element element = Element::linear) {
  auto body = std::make_shared<Body>();
  body->mesh = phantom(name, elements);
  body->material = {law, 5000, 0.4};
  body->element = element;
  body->clamp = body->mesh.groups.at("clamp");
  body->pad = Pad{.site = nearest_site(body->mesh, place)};
  return body;
}

// The phantom with its own rigid contact.
inline std::shared_ptr<Body> gripped_phantom(const std::string& name, std::size_t elements,
                                             Law law = Law::neo_hookean, Element element = Element::linear) {
  const auto body = padded_phantom(name, elements, phantom_tip(name), law, element);
  body->pad.reset();
  body->contact = body->mesh.groups.at("contact");
  return body;
}

}  // namespace forefeel
