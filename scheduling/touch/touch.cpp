#include "scheduling/touch/touch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {

namespace {

constexpr double settled = 5e-4;   // of mu f . n, or of |f| where the force pulls
constexpr double shortest = 1e-9;  // step [m]
constexpr double longest = 2e-3;   // step [m]; a longer way has several
constexpr int most_steps = 200, most_halvings = 60;
constexpr double near_limit = 0.1;    // of what the force may change by: close enough
constexpr double least_share = 0.25;  // of the bound, left to the slide
constexpr double tip_share = 0.5;     // of what the tip changes the force by, the same
constexpr double site_over_tip = 3;   // most way of the site in a frame, over the tip's
constexpr double least_way = 2e-5;    // of a site that follows a tip at rest [m]
constexpr double part = 1e-4;         // of the tip's way in a frame, of those that are tried [m]
constexpr int least_parts = 2, most_parts = 8;
constexpr double bound = 0.007, bound_floor = 1e-3;  // of |f|, and [N]: of the damped switch, a frame

// One site, seen along a direction of its facet.
struct Seen {
  SurfaceMap::Walk walk;
  TouchTerms terms;
  Vec3 drive = Vec3::Zero();  // g
  double limit = 0;           // mu f . n, 0 where the force pulls
};

class Slider {
 public:
  Slider(const TouchField& field, const Vec3& tip, double friction, double steepness,
         std::optional<SlideLimit> limit)
      : field_(field), tip_(tip), friction_(friction), steepness_(steepness), limit_(limit) {}

  Seen see(const SurfaceMap::Walk& walk) const {
    Seen seen{.walk = walk, .terms = field_.at(walk.end, tip_ - walk.end.at, false)};
    seen.drive = drive(seen.terms);
    seen.limit = friction_ * std::max(0.0, push(seen));
    return seen;
  }
  static double push(const Seen& seen) { return seen.terms.at.force.dot(seen.terms.normal); }
  static double tolerance(const Seen& seen) {
    return settled * (seen.limit > 0 ? seen.limit : seen.terms.at.force.norm()) + 1e-12;
  }

  // By how much the force has changed more than it may [N].
  double excess(const Seen& seen) const {
    return limit_ ? (seen.terms.at.force - limit_->before).norm() - limit_->change : -1;
  }
  void start(const Seen& at) {
    if (!limit_) return;
    const double by_tip = (at.terms.at.force - limit_->before).norm();
    limit_->change =
        std::max(limit_->change, by_tip + std::max(least_share * limit_->change, tip_share * by_tip));
  }
  bool limited() const { return limited_; }

  // The farthest place along `way` (length 1) to which E falls by more than friction takes, within the limit. `from` if
  // there is none. By secants of the slope, kept between the last place before it and the first one behind.
  Seen advance(const Seen& from, const Vec3& way) {
    double low = 0, low_slope = from.drive.dot(way) - from.limit, high = -1, low_excess = excess(from);
    const double guess = steepness_ > 0 ? steepness_ : from.terms.at.stiffness.norm() + 1e-300;
    const double most = limit_ ? std::min(longest, limit_->way - gone_) : longest;
    double step = std::min(std::max(low_slope / guess, 10 * shortest), most);
    Seen best = from;
    for (int i = 0; i < most_halvings && (high < 0 || high - low > shortest); ++i) {
      Seen seen = see(field_.map().walk(from.walk.end, from.walk.spot, step * way));
      const double slope = onward(seen, way);
      // No body has E < 0: there the model is wrong, and no site goes.
      const bool falls = seen.terms.at.energy <= best.terms.at.energy &&
                         seen.terms.at.energy >= std::min(0.0, best.terms.at.energy);
      const double over = excess(seen);
      if (falls && over > 0 && slope >= -tolerance(seen)) {  // back to where the force has changed enough
        high = step;
        limited_ = true;
        if (low_excess >= -near_limit * limit_->change && low > 0) break;
        step = low + std::clamp((0.5 * near_limit * limit_->change - low_excess) / (over - low_excess), 0.05,
                                0.95) *
                         (high - low);
        continue;
      }
      const bool before = falls && slope >= -tolerance(seen);
      // Where the slope would vanish.
      const double steepness = (low_slope - slope) / (step - low);
      const double wanted = falls && steepness > 0 ? step + slope / steepness : -1;
      if (wanted > 0) steepness_ = steepness;
      if (before) {
        best = seen, low = step, low_slope = slope, low_excess = over;
        if (slope <= tolerance(seen) || !seen.walk.whole) break;
        if (low >= most) {
          limited_ = most < longest;
          break;
        }
        if (limited_ && over >= -near_limit * limit_->change) break;
      } else {
        high = step;
      }
      if (high < 0)
        step = std::min(wanted > low ? std::min(wanted, 4 * low) : 2 * low, most);
      else
        step = wanted > low + 0.02 * (high - low) && wanted < high - 0.02 * (high - low) ? wanted
                                                                                         : 0.5 * (low + high);
    }
    gone_ += best.walk.step.norm();
    return best;
  }
  double steepness() const { return steepness_; }

 private:
  // -dE/dh - mu f . n, h the way so far.
  double onward(const Seen& seen, const Vec3& way) const {
    const Vec3 direction = seen.walk.step.norm() > 0 ? Vec3(seen.walk.step.normalized()) : way;
    return seen.drive.dot(direction) - seen.limit;
  }

  const TouchField& field_;
  Vec3 tip_;
  double friction_, steepness_, gone_ = 0;
  std::optional<SlideLimit> limit_;
  bool limited_ = false;
};

// Along the edge of the facet that the site stands on, downhill; zero if it is on none.
Vec3 along_edge(const SurfaceMap& map, const Seen& seen) {
  const std::array<Vec3, 3> corner = map.corners(seen.walk.end.facet);
  const Vec3 share = map.barycentric(seen.walk.end);
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3 edge = corner[(e + 1) % 3] - corner[e];
    const double height =
        share[static_cast<int>((e + 2) % 3)] * 2 * map.facet(seen.walk.end).area / edge.norm();
    if (height > 2 * shortest) continue;
    const Vec3 way = edge.normalized();
    return seen.drive.dot(way) >= 0 ? way : Vec3(-way);
  }
  return Vec3::Zero();
}

}  // namespace

Vec3 drive(const TouchTerms& terms) {
  const Vec3 g = -(terms.at.by_site + terms.at.force);
  const Vec3& n = terms.across;
  return g - n.dot(g) * n;
}

Slip slide(const TouchField& field, const SurfacePlace& from, const Vec3& tip, double friction,
           double steepness, const std::optional<SlideLimit>& limit) {
  Slider slider(field, tip, friction, steepness, limit);
  Seen here = slider.see({.end = from, .spot = field.map().spot(from)});
  slider.start(here);
  const bool pulled = Slider::push(here) < 0;
  Slip slip;
  slip.site = from, slip.pulled = pulled, slip.held = here.terms.at.force;
  const double start = here.terms.at.energy;
  slip.end = SlipEnd::unsettled;
  for (int i = 0; i < most_steps; ++i) {
    if (pulled && Slider::push(here) >= 0) {
      slip.end = SlipEnd::sticks;
      break;
    }
    if (here.drive.norm() <= here.limit + Slider::tolerance(here)) {
      slip.end = pulled ? SlipEnd::minimum : SlipEnd::sticks;
      break;
    }
    Seen next = slider.advance(here, here.drive.normalized());
    if (next.walk.step.norm() <= 2 * shortest &&
        next.walk.whole) {  // a kink: along the edge, if that goes down
      const Vec3 way = along_edge(field.map(), next);
      if (next.drive.dot(way) > next.limit + Slider::tolerance(next)) next = slider.advance(next, way);
      if (next.walk.step.norm() <= 2 * shortest) {
        slip.end = pulled ? SlipEnd::minimum : SlipEnd::sticks;
        break;
      }
    }
    slip.slid += next.walk.step.norm();
    const bool border = !next.walk.whole;
    here = next;
    here.walk.step.setZero(), here.walk.whole = true;
    if (border || slider.limited()) {
      slip.end = border ? SlipEnd::border : SlipEnd::limited;
      break;
    }
  }
  slip.site = here.walk.end, slip.terms = here.terms, slip.steepness = slider.steepness();
  slip.lost = std::max(0.0, start - here.terms.at.energy);
  return slip;
}

namespace {

// The slide of a frame. Where the limit ends it the body may have a fold, or the tip is only fast: then the site
// follows its way in parts, at most three times as far in each, and is at its end with the last.
Slip follow(const TouchField& field, const Touch& before, const SurfacePlace& from, const Vec3& tip,
            double friction, const std::optional<SlideLimit>& limit) {
  const Slip whole = slide(field, from, tip, friction, before.steepness, limit);
  const Vec3 way = tip - before.tip;
  if (whole.end != SlipEnd::limited || !(way.norm() > 0)) return whole;
  if (limit && whole.slid >= site_over_tip * way.norm() * (1 - 1e-6)) return whole;  // no parts go farther
  const int parts = std::clamp(static_cast<int>(std::ceil(way.norm() / part)), least_parts, most_parts);
  const SlideLimit in_part{.change = std::numeric_limits<double>::infinity(),
                           .way = site_over_tip * way.norm() / parts};
  Slip slip;
  slip.site = from, slip.steepness = before.steepness;
  for (int i = 1; i <= parts; ++i) {
    const Vec3 to = i < parts ? Vec3(before.tip + double(i) / parts * way) : tip;
    const double slid = slip.slid;
    slip = slide(field, slip.site, to, friction, slip.steepness, in_part);
    slip.slid += slid;
    if (slip.pulled || (slip.end != SlipEnd::sticks && slip.end != SlipEnd::limited)) return whole;
  }
  if (slip.end == SlipEnd::limited) return whole;
  // Against the start of the whole, so that the energy of the frames adds up, and only falls.
  slip.lost = whole.terms.at.energy + whole.lost - slip.terms.at.energy;
  if (slip.lost < whole.lost) return whole;
  slip.held = whole.held;
  return slip;
}

// The touch of a tip that has just come in; none through a clamped facet.
std::optional<SurfacePlace> begin(const TouchField& field, const Touch& before, const Vec3& tip) {
  std::optional<SurfacePlace> place;
  if (before.known) place = field.grid().crossing(before.tip, tip);
  if (!place) place = field.map().nearest(tip);
  if (field.map().facet(*place).clamped) return {};
  return place;
}

}  // namespace

TouchFrame touch(const TouchField& field, const Touch& before, const Vec3& tip,
                 std::optional<double> friction) {
  TouchFrame frame;
  Touch& now = frame.touch;
  now = before;
  now.tip = tip, now.known = true, now.inside = field.grid().inside(tip);
  if (before.kind == TouchKind::none) {
    if (!now.inside || (before.known && before.inside)) return frame;
    frame.began = begin(field, before, tip);
    if (!frame.began) return frame;
    now.site = *frame.began, now.kind = TouchKind::stick;
  }
  if (!now.inside) {
    const std::optional<SurfacePlace> way_out = field.grid().crossing(tip, before.tip);
    frame.left = way_out ? way_out->at : tip;
    const SiteTerms there = field.at(now.site, *frame.left - now.site.at, false).at;
    frame.tip_change = (there.force - before.force).norm();
    frame.lost = std::max(0.0, there.energy);
    now.kind = TouchKind::none;
    return frame;
  }
  now.kind = TouchKind::stick;
  TouchTerms terms;
  // A tip that is inside from the start had no way.
  const auto by_tip = [&](const Vec3& force) {
    return !frame.began ? (force - before.force).norm() : before.known ? force.norm() : 0;
  };
  if (!friction) {
    terms = field.at(now.site, tip - now.site.at, false);
    frame.tip_change = by_tip(terms.at.force);
  }
  if (friction || terms.at.force.dot(terms.normal) < 0) {
    std::optional<SlideLimit> limit;
    if (!frame.began && before.known)
      limit = {.before = before.force,
               .change = std::max(bound * before.force.norm(), bound_floor),
               .way = std::max(site_over_tip * (tip - before.tip).norm(), least_way)};
    const Slip slip = follow(field, before, now.site, tip, friction.value_or(0), limit);
    terms = slip.terms;
    frame.tip_change = by_tip(slip.held);
    frame.snaps = slip.end == SlipEnd::limited;
    now.steepness = slip.steepness;
    frame.lost = slip.lost;
    frame.at_border = slip.end == SlipEnd::border;
    if (slip.slid > 0) now.kind = TouchKind::slip, now.site = slip.site;
    if (slip.pulled && slip.end != SlipEnd::sticks && slip.end != SlipEnd::limited) {
      frame.lost += std::max(0.0, terms.at.energy);
      now.kind = TouchKind::none;
      return frame;
    }
  }
  frame.force = now.force = terms.at.force;
  frame.energy = terms.at.energy;
  frame.normal = terms.normal;
  frame.drive = drive(terms);
  return frame;
}

}  // namespace forefeel
