#include "scheduling/policy/need_policy.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/common/in_best_set.hpp"

namespace forefeel {

double urgency(double t, double solve) {
  const double late = (solve - t) / solve;
  return late > 0 ? 1 / (1 + late * late) : 1 / (1 - late);
}

double sureness(double deviation, double h) {
  return 1 / (1 + std::pow(deviation / (2 * h), 2));
}

Vec3 folded(const Vec3& x, const Box& box) {
  Vec3 inside = box.low;
  for (int i = 0; i < 3; ++i) {
    const double size = box.high[i] - box.low[i];
    if (!(size > 0) || !std::isfinite(x[i])) continue;
    const double place = std::fmod(std::abs(x[i] - box.low[i]), 2 * size);
    inside[i] += std::min(place, 2 * size - place);
  }
  return inside;
}

// Compiled with -ffp-contract=off: without fused products the versions for different instruction sets round
// identically.

namespace {

// For shorter lists of states the products are computed again; from longer lists, states are removed by division.
constexpr std::size_t few = 32;

// Smaller values count as zero. The threshold is far above denormal numbers, which are slow. It is also small
// enough that a state that leaves a millionth of a need can be removed by division.
constexpr double nothing = 1e-200;

// left_i *= 1 - m(q_i, p), one scale
FOREFEEL_INLINE void mend(std::size_t count, const double* __restrict xyz, const double* p, double inverse,
                          double* __restrict left) {
  const double* __restrict x = xyz;
  const double* __restrict y = xyz + count;
  const double* __restrict z = xyz + 2 * count;
  const double px = p[0], py = p[1], pz = p[2];
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    const double mended = 1 - (dx * dx + dy * dy + dz * dz) * inverse;
    const double now = left[i] * (1 - (mended > 0 ? mended : 0.0));
    left[i] = now < nothing ? 0.0 : now;
  }
}

}  // namespace

void NeedLeft::begin(std::span<const Vec3> at, std::span<const Needs> needs, const Needs& inverses) {
  at_.assign(at.begin(), at.end());
  for (std::size_t s = 0; s < scales; ++s) {
    Row& row = rows_[s];
    row.inverse = inverses[s];
    row.place.clear();
    row.need.clear();
    row.of.assign(at.size(), none);
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!(needs[i][s] > 0)) continue;
      row.of[i] = static_cast<std::uint32_t>(row.place.size());
      row.place.push_back(static_cast<std::uint32_t>(i));
      row.need.push_back(needs[i][s]);
    }
    const std::size_t n = row.place.size();
    row.xyz.resize(3 * n);
    for (std::size_t j = 0; j < n; ++j)
      for (unsigned k = 0; k < 3; ++k) row.xyz[k * n + j] = at[row.place[j]][k];
    row.left = row.need;
  }
  counted_.clear();
  all_.clear();
}

void NeedLeft::multiply(const Vec3& p) {
  for (Row& row : rows_)
    in_best_set<mend>(row.place.size(), row.xyz.data(), p.data(), row.inverse, row.left.data());
  counted_.push_back(p);
}

void NeedLeft::anew(std::span<const Vec3> under_way) {
  for (Row& row : rows_) row.left = row.need;
  counted_.clear();
  for (const Vec3& p : under_way) multiply(p);
}

// Divides by the factors of the removed states. Where these are nearly zero, the product of the place is
// computed again. Returns false if this does not pay or the list is not part of the longest one.
bool NeedLeft::leave_out(std::span<const Vec3> under_way) {
  if (all_.size() < few || under_way.size() > all_.size() || all_.size() - under_way.size() > few / 4)
    return false;
  std::vector<Vec3> out;
  std::size_t kept = 0;
  for (const Vec3& p : all_) {
    if (kept < under_way.size() && p == under_way[kept])
      ++kept;
    else
      out.push_back(p);
  }
  if (kept < under_way.size()) return false;
  counted_.assign(under_way.begin(), under_way.end());
  for (std::size_t s = 0; s < scales; ++s) {
    Row& row = rows_[s];
    row.left = all_left_[s];
    const auto share = [&](const Vec3& p, const Vec3& q) {
      return 1 - std::max(0.0, 1 - (q - p).squaredNorm() * row.inverse);
    };
    for (std::size_t j = 0; j < row.place.size(); ++j) {
      const Vec3& q = at_[row.place[j]];
      double gone = 1;
      for (const Vec3& p : out) gone *= share(p, q);
      double& left = row.left[j];
      if (gone == 1) continue;
      if (gone > 1e-6) {
        left /= gone;
        continue;
      }
      left = row.need[j];
      for (const Vec3& p : under_way) left *= share(p, q);
    }
  }
  return true;
}

void NeedLeft::set(std::span<const Vec3> under_way) {
  const std::size_t n = counted_.size();
  if (under_way.size() >= n && std::ranges::equal(counted_, under_way.first(n))) {
    if (under_way.size() > n) all_.clear();
    for (const Vec3& p : under_way.subspan(n)) multiply(p);
    return;
  }
  if (all_.empty()) {
    all_ = counted_;
    for (std::size_t s = 0; s < scales; ++s) all_left_[s] = rows_[s].left;
  }
  if (leave_out(under_way)) return;
  all_.clear();
  anew(under_way);
}

}  // namespace forefeel
