#pragma once
// Scenes with [contact] anywhere = true: the pad has no place of its own; a command puts it at sites of the surface.

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "apps/scene/scene.hpp"

namespace forefeel {

inline constexpr double usual_depth = 0.025;  // state_space.depth where the scene gives none [m]

// As load_scene(), which refuses contact.anywhere.
Scene load_scene_with_sites(const std::filesystem::path& file, std::span<const std::string> overrides,
                            const SceneUse& use);
bool is_anywhere(const Scene& scene);
// For the identity of a body: a pad without its site.
std::string anywhere_in_words(const Pad& pad);

// A place of the unclamped surface, where the pad of such a scene stands until it is put elsewhere. InputError at
// `where` if all of the surface is clamped.
Vec3 free_site(const Body& body, const InputPlace& where);

// The body with its pad at the place of the surface that is nearest to `wanted` [m].
struct SitedBody {
  std::shared_ptr<const Body> body;
  double clamped_share = 0;           // of the springs, carried by clamped nodes
  std::vector<std::string> warnings;  // of the pad there
};
// InputError at --site: the place is on a clamped facet, or farther from the surface than the body is long.
SitedBody put_at(const Scene& scene, const Vec3& wanted);

}  // namespace forefeel
