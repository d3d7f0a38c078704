#include "approx/model/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "approx/loops/view_loops.hpp"
#include "approx/model/model_options.hpp"
#include "approx/model/views.hpp"

namespace forefeel {
namespace {

constexpr double loyalty = 0.95;  // of the distance of a member of the last set
constexpr std::size_t most_candidates = 8192;
constexpr std::size_t few = 256;  // up to this number of states, all are candidates
constexpr double beyond_all = std::numeric_limits<double>::infinity();

// In spacings:
constexpr double shell =
    2.5;  // depth behind the nearest state in which states determine the position of a side
constexpr double pulled_to = 0.25;  // before the nearest state of a side;
constexpr double pulled_r =
    2.2;                      // and for kernel r, for which one or two layers suffice, before a single side
constexpr double band = 0.4;  // of the key, over which a weight rises;
constexpr double band_r5 = 0.8;   // the same for r^5 on force, which extrapolates farthest;
constexpr double band_r = 1.4;    // the same for r, whose ridge falls least steeply with w
constexpr double entering = 2;    // before the end of the candidates' distance, over which a state enters
constexpr double farthest = 32;   // a far side
constexpr double fading = 8;      // before that, over which it fades
constexpr double at_hip = 0.25;   // within this distance of the HIP, the direction of a state is unreliable
constexpr double off_view = 100;  // added to the apparent distance, per square of the deviation from a view
constexpr double in_view = 0.3;   // cosine to a view below which a state deviates from it
constexpr double least_weight = 1e-10;
constexpr double least_near = 1e-3;  // least weight in the nearer side, if the far side is far more crowded
constexpr double full_narrow = 0.2;  // c_i from which a state may count fully
// Keys are measured from a point a little aside, so that states of a lattice enter one by one, not shell by
// shell.
const Vec3 aside(0.17, -0.11, 0.07);
constexpr double least_ratio = 0.1;  // (d_1 + h) / (d + h) from which a far side enters

// Cells of directions, to leave out hidden states early. A cell is so small (at most 35.3 degrees across,
// views within 21.6 degrees) that a state in it does not deviate from any view used for another state of the
// same cell.
constexpr int coarse = 4;
constexpr double least_sharp = 0.55;  // a state hides others only if it has a clear direction
constexpr double beyond = 1.2;        // keys are computed up to this multiple of the last one
constexpr double first_end = 0.6;     // limit of the keys computed first, in radii of a half ball of n states

// From 0 to 1 on [0, 1], twice differentiable.
double rise(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

// Radius of a half ball of n states, in spacings.
double half_ball(std::size_t n) {
  return std::cbrt(1.5 * double(n) / M_PI);
}

using detail::Views;

constexpr std::size_t lanes = 8, arrays = 5;

}  // namespace

NeighbourSelector::Sizes NeighbourSelector::sizes_of(const ModelOptions& options) {
  const std::size_t weighted = weighted_neighbours(options);
  return {.plain = nearest_neighbours(options),
          .weighted = weighted,
          .rank = weighted + weighted / 6,
          .bridging = bridging_neighbours(options),
          .most = most_neighbours(options)};
}

NeighbourSelector::Widths NeighbourSelector::widths_of(const ModelOptions& options, std::size_t rank,
                                                       double spacing) {
  if (options.kernel == Kernel::linear)
    return {.spacing = spacing,
            .pulled = std::clamp(half_ball(rank) - 1.6, pulled_to, pulled_r),
            .band = band_r,
            .steep = 2};
  const bool far = options.kernel == Kernel::quintic && options.data == Data::force;
  return {.spacing = spacing, .pulled = pulled_to, .band = far ? band_r5 : band, .steep = 1};
}

NeighbourSelector::NeighbourSelector(const StateSpace& space, const ModelOptions& options)
    : space_(space),
      sizes_(sizes_of(options)),
      rule_(options.select),
      widths_(widths_of(options, sizes_.rank, space.options().spacing)) {
  look_.room = std::max(most_candidates, 2 * sizes_.weighted + 16);
  found_.reserve(look_.room);
  candidates_.reserve(look_.room);
  keys_.reserve(look_.room);
  look_.room = (look_.room + lanes - 1) / lanes * lanes;
  look_.arrays.resize(arrays * look_.room);
  look_.views.resize(detail::views().all.size());
  look_.done.reserve(look_.views.size());
  look_.before.resize(6 * coarse * coarse);
  last_.reserve(sizes_.most);
  chosen_.reserve(look_.room);
}

void NeighbourSelector::forget() {
  last_.clear();
}

// Collects the candidates: the states within `radius` of the HIP, or the `least` nearest ones if these are
// more. Returns the distance up to which no state is missing, a continuous function of the HIP.
double NeighbourSelector::gather(const Vec3& hip, std::size_t least, double radius) {
  found_.clear();
  if (radius > 0 && space_.size() > least) space_.within(hip, radius, found_);
  bool by_number = false;
  if (found_.size() < least || found_.size() > most_candidates) {
    by_number = true;
    walk_.nearest(space_, hip, std::min(most_candidates, std::max(least, found_.size())), found_);
  }
  candidates_.clear();
  for (const StateId id : found_) {
    const Vec3 away = space_[id].at - hip;
    const double distance = away.norm();
    candidates_.push_back({.key = distance,
                           .id = id,
                           .towards = distance > 0 ? Vec3(away / distance) : Vec3(Vec3::Zero()),
                           .distance = distance});
  }
  if (space_.size() <= least) return beyond_all;
  return by_number ? candidates_.back().distance : radius;
}

void NeighbourSelector::keep_first(std::size_t count) {
  const auto before = [](const Nearby& a, const Nearby& b) {
    return a.key != b.key ? a.key < b.key : a.id < b.id;
  };
  count = std::min(count, candidates_.size());
  const auto middle = candidates_.begin() + static_cast<std::ptrdiff_t>(count);
  if (middle != candidates_.end()) std::nth_element(candidates_.begin(), middle, candidates_.end(), before);
  for (auto c = candidates_.begin(); c != middle; ++c) chosen_.push_back({.id = c->id});
}

void NeighbourSelector::take_nearest(const Vec3& hip) {
  gather(hip, sizes_.plain + sizes_.plain / 4 + 8, 0);
  for (Nearby& c : candidates_)
    if (std::ranges::binary_search(last_, c.id)) c.key *= loyalty;
  keep_first(sizes_.plain);
}

// Prepares the arrays of the loops, candidates from near to far, and for each cell the distance of what hides
// others.
void NeighbourSelector::look_round() {
  const std::size_t n = candidates_.size(), padded = (n + lanes - 1) / lanes * lanes;
  double *x = look_.arrays.data(), *y = x + look_.room, *z = y + look_.room, *distance = z + look_.room;
  std::ranges::fill(look_.before, beyond_all);
  for (std::size_t i = 0; i < n; ++i) {
    Nearby& c = candidates_[i];
    const double sharp = c.distance / (c.distance + at_hip * widths_.spacing);
    x[i] = sharp * c.towards[0];
    y[i] = sharp * c.towards[1];
    z[i] = sharp * c.towards[2];
    distance[i] = c.distance;
    c.cell = c.distance > 0 ? static_cast<std::uint32_t>(Views::cell_of(c.towards, coarse)) : 0;
    if (sharp > least_sharp) look_.before[c.cell] = std::min(look_.before[c.cell], c.distance);
  }
  for (std::size_t i = n; i < padded; ++i) {
    x[i] = y[i] = z[i] = 0;
    distance[i] = 1e300;
  }
  look_.done.assign(look_.views.size(), 0);
}

// The least apparent distance along a fixed view, and the mean direction to the states about as near.
const Eigen::Vector4d& NeighbourSelector::view(std::size_t k) {
  Eigen::Vector4d& at = look_.views[k];
  if (look_.done[k] != 0) return at;
  look_.done[k] = 1;
  const double *x = look_.arrays.data(), *y = x + look_.room, *z = y + look_.room, *distance = z + look_.room;
  double* seen = look_.arrays.data() + 4 * look_.room;
  const std::size_t padded = (candidates_.size() + lanes - 1) / lanes * lanes;
  const std::size_t end =
      view::loops().seen(padded, x, y, z, distance, detail::views().all[k].data(), in_view,
                         off_view * widths_.spacing, shell * widths_.spacing, seen, &at[3]);
  view::loops().towards(end, x, y, z, seen, at[3], shell * widths_.spacing, at.data());
  if (const double norm = at.head<3>().norm(); norm > 0) at.head<3>() /= norm;
  return at;
}

// d_i and t_i: blended from the fixed views around the state's direction.
void NeighbourSelector::look_along(Nearby& c) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  double total = 0;
  const Views& views = detail::views();
  if (c.distance > 0)
    for (const std::uint16_t k : views.of(c.towards)) {
      const double about = std::max(0.0, views.all[k].dot(c.towards) - Views::turned);
      if (about == 0) continue;
      const double w = about * about;
      total += w;
      sum += w * view(k);
    }
  sum /= total > 0 ? total : 1;
  c.side_towards = sum.head<3>();
  // A state at the HIP itself has no direction: its own distance counts.
  c.side_at = total > 0 ? std::min(sum[3], c.distance) : c.distance;
}

// beta: how much a side at this distance counts.
double NeighbourSelector::share(double distance) const {
  const double ratio = (around_.nearest + widths_.spacing) / (distance + widths_.spacing),
               limit = std::max(farthest * widths_.spacing, around_.nearest + fading * widths_.spacing);
  return std::clamp((ratio - least_ratio) / (1 - least_ratio), 0.0, 1.0) *
         std::clamp((limit - distance) / (fading * widths_.spacing), 0.0, 1.0);
}

// 1 if the directions to the nearest states cancel, or if something that counts lies opposite to them; 0 for
// one side.
double NeighbourSelector::two_sided() const {
  double total = 0;
  Vec3 ahead = Vec3::Zero();
  for (const Nearby& c : candidates_) {
    const double near = 1 - (c.distance - around_.nearest) / (shell * widths_.spacing);
    if (near <= 0) continue;
    total += near * near;
    ahead += near * near * c.distance / (c.distance + at_hip * widths_.spacing) * c.towards;
  }
  const double one_sided = ahead.norm() / total;
  double most = rise(1 - 2 * one_sided);
  if (one_sided > 0)
    for (const Nearby& c : candidates_) {
      const double sharp = std::min(1.0, c.distance / (at_hip * widths_.spacing));
      most = std::max(most, share(c.distance) * rise(-sharp * c.towards.dot(ahead) / (one_sided * total)));
    }
  return most;
}

// The key of a real rank, between those of the two ranks around it; `last`: the second of these, which may be
// beyond_all.
double NeighbourSelector::key_of(double rank, double& last) {
  const auto first = static_cast<std::ptrdiff_t>(rank) - 1;
  const double part = rank - std::floor(rank);
  last = beyond_all;
  if (first >= std::ssize(keys_)) return beyond_all;
  const auto at = keys_.begin() + first;
  std::nth_element(keys_.begin(), at, keys_.end());
  if (part == 0) return last = *at;
  if (first + 1 < std::ssize(keys_)) last = *std::min_element(at + 1, keys_.end());
  return 1 / ((1 - part) / *at + part / last);
}

// Computes the keys of all candidates that can come before rank n, and returns the key of rank n. The key of
// a state is at least its distance behind the state that hides it, so most hidden states need not be looked
// at.
double NeighbourSelector::find_keys(const Vec3& hip, double pulled, double rank) {
  keys_.clear();
  for (Nearby& c : candidates_) {
    c.key = beyond_all;
    c.looked = false;
  }
  double limit = first_end * half_ball(sizes_.rank) * widths_.spacing;
  for (bool all = false;;) {
    double next = beyond_all;
    for (Nearby& c : candidates_) {
      if (c.looked) continue;
      const double hidden = c.distance - std::max(0.0, look_.before[c.cell] * (1 + 1e-9) - pulled) -
                            aside.norm() * widths_.spacing;
      if (!all && hidden > limit) {
        next = std::min(next, hidden);
        continue;
      }
      c.looked = true;
      look_along(c);
      c.share = share(c.side_at);
      c.narrow = std::cbrt(c.share * (around_.nearest + widths_.spacing) / (c.side_at + widths_.spacing)) *
                 std::clamp((around_.whole - c.distance) / (entering * widths_.spacing), 0.0, 1.0);
      if (!(c.narrow > 0)) continue;
      const Vec3 from = hip + std::max(0.0, c.side_at - pulled) * c.side_towards + widths_.spacing * aside;
      c.key = (space_[c.id].at - from).norm() / c.narrow;
      keys_.push_back(c.key);
    }
    double last = beyond_all;
    const double end = key_of(rank, last);
    limit = std::max(beyond * end, last);
    if (limit <= next) return end;
    all = limit == beyond_all;
  }
}

// The largest distance of a counting state from the point its key is measured from. It replaces the key of
// rank n if there are hardly n states, because that key is then arbitrary.
double NeighbourSelector::extent(double end) {
  double most = 0;
  for (const Nearby& c : candidates_) {
    if (!(c.key < beyond * end)) continue;
    const double inside =
        end < beyond_all ? std::min(1.0, 2 * (beyond * end - c.key) / ((beyond - 1) * end)) : 1;
    const double whole = std::min(1.0, c.narrow / full_narrow);  // cubed: c_i is a cube root
    most = std::max(most, inside * whole * whole * whole * c.key * c.narrow);
  }
  return most;
}

void NeighbourSelector::take_sides(const Vec3& hip) {
  found_.clear();
  space_.nearest(hip, 1, found_);
  around_.nearest = (space_[found_.front()].at - hip).norm();
  const double reach =
      1.2 + 1.2 * std::cbrt(0.5 * double(sizes_.weighted));  // of a half ball of n, in spacings
  const double limit = std::max(farthest * widths_.spacing, around_.nearest + fading * widths_.spacing);
  const double wide = std::max(around_.nearest + reach * widths_.spacing,
                               std::min((around_.nearest + widths_.spacing) / least_ratio, limit)) +
                      (shell + entering) * widths_.spacing;
  around_.whole = gather(hip, std::max(few, 2 * sizes_.most), wide) - shell * widths_.spacing;
  look_round();

  const double both = two_sided(), pulled = widths_.pulled + both * (pulled_to - widths_.pulled);
  set_.bridge = rise((both - 0.1) / 0.5);
  const std::size_t others = space_.size() > sizes_.rank + 2 ? space_.size() - sizes_.rank - 2 : 0;
  const double end = find_keys(hip, pulled * widths_.spacing,
                               double(sizes_.rank) + set_.bridge * double(std::min(sizes_.bridging, others)));
  if (keys_.empty()) return;
  set_.radius = std::min(end, extent(end));
  weigh(hip, end);
}

void NeighbourSelector::weigh(const Vec3& hip, double end) {
  // If the set is wider than states one spacing apart would be, weights rise more slowly; if it is denser,
  // faster.
  const double usual = half_ball(sizes_.rank), mean_spacing = set_.radius / usual;
  const double wide_band = widths_.band * std::max({mean_spacing, std::min(widths_.spacing, 2 * mean_spacing),
                                                    1e-6 * widths_.spacing});
  double total = 0;
  Vec3 mean = Vec3::Zero();
  for (Nearby& c : candidates_) {
    c.rank = 0;
    if (!(c.key < end)) continue;
    // If there are fewer than n states, a side enters by its share alone.
    c.rank = std::clamp(std::min((end - c.key) * c.narrow / wide_band, c.narrow / full_narrow), 0.0, 1.0);
    const double w = rise(c.rank);
    total += w;
    mean += w * (space_[c.id].at - hip);
  }
  if (total > 0) mean /= total;
  for (const Nearby& c : candidates_) {
    const double w = rise(c.rank);
    if (!(w > least_weight)) continue;
    // A lone state on the far side determines the force over this length, however small its weight.
    const double apart =
        1 + std::max(0.0, (space_[c.id].at - hip - mean).norm() / widths_.spacing - 1.5 * usual);
    const double near = w * (least_near + (1 - least_near) * rise(2 * c.share - 1));
    chosen_.push_back({c.id, w, near, std::pow(apart, widths_.steep * (1 - c.rank))});
  }
}

Label NeighbourSelector::select(const Vec3& hip, std::vector<Neighbour>& out) {
  out.clear();
  set_.bridge = set_.radius = 0;
  set_.sided = false;
  if (space_.empty()) return Label::blank;
  const Label label = walk_.label(space_, hip);
  chosen_.clear();
  if (rule_ == Select::nearest) {
    walk_.nearest(space_, hip, sizes_.plain, found_);
    for (const StateId id : found_) chosen_.push_back({.id = id});
  } else if (label == Label::safe || space_.size() <= sizes_.plain || sizes_.plain == 1) {
    take_nearest(hip);  // no choice if all states fit; no weights for one neighbour
  } else {
    take_sides(hip);
    set_.sided = !chosen_.empty();
    if (!set_.sided) take_nearest(hip);
  }
  std::ranges::sort(chosen_, {}, &Neighbour::id);
  if (chosen_.size() > sizes_.most) chosen_.resize(sizes_.most);
  last_.clear();
  for (const Neighbour& member : chosen_) last_.push_back(member.id);
  out.assign(chosen_.begin(), chosen_.end());
  return label;
}

}  // namespace forefeel
