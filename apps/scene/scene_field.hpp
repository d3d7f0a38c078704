#pragma once
// The field of a scene with contact.anywhere = true: what its body at rest says about a touch at any place
// (solver/jet/site_field.hpp). It is that of the fine body, if the scene has one. Compliance and jets are kept in the
// cache folder, by body, pad and site_spacing.

#include <memory>
#include <stop_token>

#include "apps/scene/scene.hpp"
#include "solver/jet/field_patches.hpp"
#include "solver/jet/site_field.hpp"

namespace forefeel {

struct Globals;

struct FieldFound {
  std::shared_ptr<const SiteField> field;
  double seconds = 0;  // that making or reading it took
  bool kept = false;   // it was read from the cache
};

// Uses globals.threads, and shows progress unless globals.quiet. Stopped early it has fewer sites, and is not kept.
// InputError if the body has no stable equilibrium at rest.
FieldFound find_field(const Scene& scene, const Globals& globals, const std::stop_token& stop = {});
// The field for a moving hand (solver/jet/field_patches.hpp), kept in the cache beside it.
std::shared_ptr<const FieldPatches> find_patches(const Scene& scene, std::shared_ptr<const SiteField> field,
                                                 const Globals& globals, const std::stop_token& stop = {});
// Without a field: for other processes that solve. One thread.
std::shared_ptr<const RestSites> rest_sites_of(const Scene& scene);
std::shared_ptr<const SiteField> site_field_of(const Scene& scene, const Globals& globals,
                                               const std::stop_token& stop = {});

}  // namespace forefeel
