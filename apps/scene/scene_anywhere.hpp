#pragma once
// Scenes with [contact] anywhere = true: the pad has no place of its own; a command puts it at sites of the surface.

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_table.hpp"

namespace forefeel {

// As load_scene(), which refuses contact.anywhere.
Scene load_scene_with_sites(const std::filesystem::path& file, std::span<const std::string> overrides,
                            const SceneUse& use);
bool is_anywhere(const Scene& scene);
// contact.friction, contact.site_spacing and state_space.depth; nullopt without contact.anywhere, and InputError for
// one of these keys then.
std::optional<AnywhereKeys> read_anywhere(const SceneTable& contact, const SceneTable& state_space);
// For the identity of a body: a pad without its site.
std::string anywhere_in_words(const Pad& pad);

// A place of the unclamped surface, where the pad of such a scene stands until it is put elsewhere. InputError at
// `where` if all of the surface is clamped.
Vec3 free_site(const Body& body, const InputPlace& where);

}  // namespace forefeel
