#include "scheduling/touch/site_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {
namespace {

constexpr double jets_apart = 0.25;     // of the field's spacing
constexpr double trust_factor = 3;      // that of DeepStates::trusted()
constexpr double choose_every = 0.010;  // where nothing has changed [s]

}  // namespace

SiteCandidates::SiteCandidates(const StateSpace& space, SurfaceModels& models)
    : space_(space), models_(models), field_(models.task().field_of_sites()) {
  const TouchTask& task = models_.task();
  if (!task.patches)
    for (std::size_t i = 0; i < task.field->size(); ++i) jets_.push_back(task.field->place(i));
}

// Where the tip will press. A bonded touch keeps its site; else the site is taken to follow the tip.
void SiteCandidates::predict_visits(std::span<const Prediction> path, const HipSample& hip) {
  const TouchTask& task = models_.task();
  const SurfaceMap& map = field_.map();
  visits_.clear();
  std::optional<SurfacePlace> site;
  if (hip.site.exists()) site = hip.site;
  Vec3 before = hip.at;
  for (const Prediction& p : path) {
    if (!task.grid->inside(p.at)) {
      site.reset();
    } else if (!site) {
      site = task.grid->crossing(before, p.at);
      if (!site) site = map.nearest(p.at);
    } else if (task.friction) {
      const SurfacePlace under = map.nearest(p.at);
      const Vec3 x = p.at - site->at;
      // A site is dragged where the tip leans over by more than the cone allows.
      if ((under.at - site->at).norm() > *task.friction * x.norm()) site = under;
    }
    if (site && !map.facet(*site).clamped) visits_.push_back({*site, p.at - site->at});
    before = p.at;
  }
}

bool SiteCandidates::near_jet(const SurfacePlace& site) const {
  const double apart = jets_apart * models_.task().site_spacing();
  return std::ranges::any_of(
      jets_, [&](const SurfacePlace& jet) { return (jet.at - site.at).squaredNorm() < apart * apart; });
}

std::optional<SurfacePlace> SiteCandidates::missing_jet() const {
  for (const Visit& visit : visits_)
    if (!near_jet(visit.site)) return visit.site;
  return {};
}

SiteCandidates::Key SiteCandidates::key_of(const SurfacePlace& site, const Vec3& tip) const {
  Key key;
  for (Eigen::Index i = 0; i < 3; ++i) {
    key[static_cast<std::size_t>(i)] =
        static_cast<std::int32_t>(std::lround(tip[i] / space_.options().spacing));
    key[static_cast<std::size_t>(i) + 3] =
        static_cast<std::int32_t>(std::lround(2 * site.at[i] / models_.task().site_spacing()));
  }
  return key;
}

// 0 <= -x . n <= depth, and |x_t| at most half of it.
bool SiteCandidates::in_region(const Visit& visit, const Vec3& normal) const {
  const double deep = -visit.x.dot(normal), depth = models_.task().depth;
  return deep >= 0 && deep <= depth && (visit.x + deep * normal).norm() <= 0.5 * depth;
}

double SiteCandidates::distance(const Vec3& tip) const {
  std::vector<StateId> nearest;
  space_.nearest(tip, 1, nearest);
  return nearest.empty() ? std::numeric_limits<double>::infinity()
                         : (space_[nearest.front()].at - tip).norm();
}

void SiteCandidates::follow(std::span<const Prediction> path, const HipSample& hip, double now) {
  if (!changed_ && now - chosen_ < choose_every) return;
  changed_ = false, chosen_ = now;
  field_.use(models_.latest()->deep.get());
  predict_visits(path, hip);
  const TouchTask& task = models_.task();
  const double h = space_.options().spacing;
  std::map<Key, Candidate> found;
  for (const Visit& visit : visits_) {
    const Vec3 middle = ((visit.site.at + visit.x) / h).array().round();
    for (int ix = -1; ix <= 1; ++ix)
      for (int iy = -1; iy <= 1; ++iy)
        for (int iz = -1; iz <= 1; ++iz) {
          const Vec3 tip = h * (middle + Vec3(ix, iy, iz));
          const Key key = key_of(visit.site, tip);
          if (gone_.contains(key) || found.contains(key)) continue;
          const Visit at{visit.site, tip - visit.site.at};
          const TouchTerms terms = field_.at(at.site, at.x, false);
          if (!in_region(at, terms.normal)) continue;
          const double allowed = task.tolerance * std::max(terms.at.force.norm(), task.floor);
          if (!(trust_factor * field_.estimate(at.site, at.x) > allowed)) continue;
          const Asked& asked =
              asked_.try_emplace(key, Asked{now, static_cast<std::uint32_t>(asked_.size())}).first->second;
          found.emplace(key, Candidate{.at = tip,
                                       .region = with_regions_ ? space_.region_label(tip) : Label::blank,
                                       .requested = asked.requested,
                                       .delta = distance(tip),
                                       .order = asked.order,
                                       .passing = true,
                                       .site = at.site});
        }
  }
  open_.clear();
  for (const auto& [key, candidate] : found) open_.push_back(candidate);
}

Candidate SiteCandidates::take(std::size_t i) {
  const Candidate taken = open_[i];
  open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(i));
  gone_.emplace(key_of(taken.site, taken.at), true);
  return taken;
}

std::optional<Candidate> SiteCandidates::take_rest() {
  const std::optional<SurfacePlace> site = missing_jet();
  if (!site) return {};
  jets_.push_back(*site);
  return Candidate{
      .at = site->at,
      .requested = chosen_,
      .delta = distance(site->at),
      .order = std::numeric_limits<std::uint32_t>::max() - static_cast<std::uint32_t>(jets_.size()),
      .passing = true,
      .site = *site};
}

std::optional<std::size_t> SiteCandidates::index_of(const Candidate& candidate) const {
  const auto found = std::ranges::find(open_, candidate.order, &Candidate::order);
  if (found == open_.end()) return {};
  return static_cast<std::size_t>(found - open_.begin());
}

void SiteCandidates::put_back(Candidate candidate) {
  gone_.erase(key_of(candidate.site, candidate.at));
  if (candidate.displacement().isZero(0)) std::erase(jets_, candidate.site);
  changed_ = true;
}

void SiteCandidates::learn(const Candidate& known) {
  if (known.displacement().isZero(0) && !std::ranges::count(jets_, known.site)) jets_.push_back(known.site);
  changed_ = true;
}

void SiteCandidates::refresh_regions() {
  if (with_regions_) return;
  with_regions_ = true;
  for (Candidate& candidate : open_) candidate.region = space_.region_label(candidate.at);
}

Candidate SiteCandidates::refreshed(Candidate candidate) const {
  candidate.region = space_.region_label(candidate.at);
  candidate.delta = distance(candidate.at);
  return candidate;
}

double SiteCandidates::estimated(const Vec3& tip) const {
  if (visits_.empty()) return 0;
  const Visit& visit = *std::ranges::min_element(
      visits_, {}, [&](const Visit& v) { return (v.site.at + v.x - tip).squaredNorm(); });
  const TouchTask& task = models_.task();
  const Vec3 x = tip - visit.site.at;
  const double error = std::min(field_.estimate(visit.site, x), 1e3);
  return error / (task.tolerance * std::max(field_.at(visit.site, x, false).at.force.norm(), task.floor));
}

}  // namespace forefeel
