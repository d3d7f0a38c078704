#include "apps/sites/sited_body.hpp"

#include <fmt/format.h>

#include "apps/scene/scene_fine.hpp"
#include "solver/body/pad.hpp"
#include "solver/sites/surface_map.hpp"

namespace forefeel {
namespace {

std::shared_ptr<const FineJet> fine_jet_at(const Scene& scene, const Body& body, bool quiet) {
  FineBodies fine = *scene.touch.anywhere->fine;
  fine.first.pad->site = nearest_site(fine.first.mesh, body.pad->site);
  if (fine.second) fine.second->pad->site = nearest_site(fine.second->mesh, body.pad->site);
  return fine_jet_of(body, fine, {.file = scene.source.file.string(), .key = "body.fine"}, quiet);
}

}  // namespace

SitedBody put_at(const Scene& scene, const Vec3& wanted, bool quiet) {
  const SurfaceMap map(*scene.body);
  const SurfacePlace site = map.nearest(wanted);
  const auto in_words = [](const Vec3& x) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]);
  };
  const double distance = (site.at - wanted).norm();
  if (!(distance <= longest_side(scene.body->mesh)))
    throw InputError("--site",
                     fmt::format("{} is {:.3g} m from the surface, farther than the body is long; expected "
                                 "a place near it, in metres",
                                 in_words(wanted), distance));
  if (map.facet(site).clamped)
    throw InputError("--site",
                     fmt::format("{} is on a clamped facet (nearest to {}), expected a place that can move",
                                 in_words(site.at), in_words(wanted)));
  auto body = std::make_shared<Body>(*scene.body);
  body->pad->site = site.at;
  SitedBody sited{.body = body,
                  .clamped_share = clamped_share(*body, pad_surface(body->mesh, *body->pad)),
                  .warnings = check(*body, scene.source.file.string())};
  if (scene.touch.anywhere->fine) body->fine = fine_jet_at(scene, *body, quiet);
  if (sited.clamped_share > 0)
    sited.warnings.push_back(
        fmt::format("the pad at {} reaches over the clamp: {:.1f} % of its springs pull on clamped "
                    "nodes",
                    in_words(site.at), 100 * sited.clamped_share));
  return sited;
}

}  // namespace forefeel
