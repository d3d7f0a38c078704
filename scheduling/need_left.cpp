// Compiled without contraction to fused products, so that the clones round alike.
#include "scheduling/need_left.hpp"

#include <algorithm>

#include "geometry/simd.hpp"

namespace forefeel {
namespace {

constexpr std::size_t few = 32;   // under way: so many are multiplied anew rather than divided by what is left out

// left_i *= 1 - m(q_i, p), one scale
FOREFEEL_CLONES
void mend(std::size_t count, const double* __restrict xyz, const double* p, double inverse, double* __restrict left) {
  const double* __restrict x = xyz;
  const double* __restrict y = xyz + count;
  const double* __restrict z = xyz + 2 * count;
  const double px = p[0], py = p[1], pz = p[2];
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    const double mended = 1 - (dx * dx + dy * dy + dz * dz) * inverse;
    left[i] *= 1 - (mended > 0 ? mended : 0.0);
  }
}

}  // namespace

void NeedLeft::begin(std::span<const Vec3> at, std::span<const Needs> needs, const Needs& inverses) {
  const std::size_t n = at.size();
  xyz_.resize(3 * n);
  needs_.resize(scales * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) xyz_[k * n + i] = at[i][static_cast<Eigen::Index>(k)];
    for (std::size_t s = 0; s < scales; ++s) needs_[s * n + i] = needs[i][s];
  }
  inverses_ = inverses;
  left_ = needs_;
  counted_.clear();
  all_.clear();
}

void NeedLeft::multiply(const Vec3& p) {
  const std::size_t n = places();
  for (std::size_t s = 0; s < scales; ++s) mend(n, xyz_.data(), p.data(), inverses_[s], left_.data() + s * n);
  counted_.push_back(p);
}

void NeedLeft::anew(std::span<const Vec3> under_way) {
  left_ = needs_;
  counted_.clear();
  for (const Vec3& p : under_way) multiply(p);
}

// Divides by what the states left out mend; where that is nearly everything, anew for the place.
bool NeedLeft::leave_out(std::span<const Vec3> under_way) {
  if (all_.size() < few || under_way.size() > all_.size() || all_.size() - under_way.size() > few / 4) return false;
  std::vector<Vec3> out;
  std::size_t kept = 0;
  for (const Vec3& p : all_) {
    if (kept < under_way.size() && p == under_way[kept])
      ++kept;
    else
      out.push_back(p);
  }
  if (kept < under_way.size()) return false;
  left_ = all_left_;
  counted_.assign(under_way.begin(), under_way.end());
  const std::size_t n = places();
  const auto share = [&](const Vec3& p, std::size_t i, double inverse) {
    return 1 - std::max(0.0, 1 - (at(i) - p).squaredNorm() * inverse);
  };
  for (std::size_t s = 0; s < scales; ++s)
    for (std::size_t i = 0; i < n; ++i) {
      if (!(needs_[s * n + i] > 0)) continue;
      double gone = 1;
      for (const Vec3& p : out) gone *= share(p, i, inverses_[s]);
      double& left = left_[s * n + i];
      if (gone == 1) continue;
      if (gone > 1e-6) {
        left /= gone;
        continue;
      }
      left = needs_[s * n + i];
      for (const Vec3& p : under_way) left *= share(p, i, inverses_[s]);
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
    all_left_ = left_;
  }
  if (leave_out(under_way)) return;
  all_.clear();
  anew(under_way);
}

}  // namespace forefeel
