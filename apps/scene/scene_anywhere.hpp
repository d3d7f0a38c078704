#pragma once
// Scenes with [contact] anywhere = true: the pad has no place of its own; a command puts it at sites of the surface.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_table.hpp"

namespace forefeel {

// As load_scene(), which refuses contact.anywhere.
Scene load_scene_with_sites(const std::filesystem::path& file, std::span<const std::string> overrides,
                            const SceneUse& use, const Scene* like = nullptr);
bool is_anywhere(const Scene& scene);
// contact.friction or bonded, contact.site_spacing and state_space.depth; nullopt without contact.anywhere, and
// InputError for one of these keys then. A box without a depth gives its own, and a warning says so.
std::optional<AnywhereKeys> read_anywhere(const SceneTable& contact, const SceneTable& state_space,
                                          std::vector<std::string>& warnings);
// For the identity of a body: a pad without its site.
std::string anywhere_in_words(const Pad& pad);

// A place of the unclamped surface, where the pad of such a scene stands until it is put elsewhere. InputError at
// `where` if all of the surface is clamped.
Vec3 free_site(const Body& body, const InputPlace& where);

// The body with its pad at the place of the surface that is nearest to `wanted` [m]; corrected by the fine body's jet
// there, if the scene has one.
struct SitedBody {
  std::shared_ptr<const Body> body;
  double clamped_share = 0;           // of the springs, carried by clamped nodes
  double thickness = 0;               // of the body at rest under it (SurfaceMap::thickness) [m]
  Vec3 normal = Vec3::Zero();         // mean, under the pad
  std::vector<std::string> warnings;  // of the pad there
  // A line where the displacement x [m] goes deeper than the body is thick there.
  std::optional<std::string> beyond(const Vec3& x) const;
};
// InputError at --site: the place is on a clamped facet, or farther from the surface than the body is long. quiet: no
// progress line.
SitedBody put_at(const Scene& scene, const Vec3& wanted, bool quiet = true);

// The command that made a run or states, and the hash of its scene; empty if not known.
struct MadeBy {
  std::string command, scene_hash;
};
MadeBy made_by(const std::string& provenance);  // JSON, as console/provenance.hpp makes it
// The scene of that command, anywhere or grasped, if its file is still there and unchanged.
std::optional<Scene> scene_of(const MadeBy& made_by);

}  // namespace forefeel
