#include "geometry/segmentation/label_domain.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace forefeel {
namespace {

constexpr std::size_t smallest_seeded =
    8;  // voxels; lesser parts are noise, unless a label has no larger one

}  // namespace

LabelDomain::LabelDomain(const LabelVolume& volume, std::vector<int> subdomain_of_value)
    : volume_(volume), subdomain_(std::move(subdomain_of_value)), to_index_(volume.axes.inverse()) {
  low_ = volume.size;
  high_ = {-1, -1, -1};
  for (std::int64_t k = 0; k < volume.size[2]; ++k)
    for (std::int64_t j = 0; j < volume.size[1]; ++j)
      for (std::int64_t i = 0; i < volume.size[0]; ++i) {
        if (voxel(i, j, k) == 0) continue;
        ++wanted_;
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t d = 0; d < 3; ++d)
          low_[d] = std::min(low_[d], at[d]), high_[d] = std::max(high_[d], at[d]);
      }
  find_parts();
}

int LabelDomain::voxel(std::int64_t i, std::int64_t j, std::int64_t k) const {
  if (i < 0 || j < 0 || k < 0 || i >= volume_.size[0] || j >= volume_.size[1] || k >= volume_.size[2])
    return 0;
  return subdomain_[volume_.voxels[volume_.at(i, j, k)]];
}

int LabelDomain::at(const Vec3& x) const {
  const Vec3 index = to_index_ * (x - volume_.origin);
  std::array<std::int64_t, 3> base;
  Vec3 share;
  for (unsigned d = 0; d < 3; ++d) {
    const double q = index[d], floor = std::floor(q);
    if (!(q > static_cast<double>(low_[d] - 1) && q < static_cast<double>(high_[d] + 1))) return 0;
    base[d] = static_cast<std::int64_t>(floor);
    share[d] = q - floor;
  }
  std::array<int, 8> corner;
  bool same = true;
  for (unsigned c = 0; c < 8; ++c) {
    corner[c] = voxel(base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2));
    same = same && corner[c] == corner[0];
  }
  if (same) return corner[0];
  std::array<double, 8> weight{};  // of the label of corner c, at its first corner
  for (std::size_t c = 0; c < 8; ++c) {
    const auto first = static_cast<std::size_t>(std::ranges::find(corner, corner[c]) - corner.begin());
    weight[first] += ((c & 1) ? share[0] : 1 - share[0]) * ((c & 2) ? share[1] : 1 - share[1]) *
                     ((c & 4) ? share[2] : 1 - share[2]);
  }
  std::size_t best = 0;
  for (std::size_t c = 1; c < 8; ++c)
    if (weight[c] > weight[best] || (weight[c] == weight[best] && corner[c] < corner[best])) best = c;
  return corner[best];
}

Box LabelDomain::box() const {
  Box box;
  for (int c = 0; c < 8; ++c) {
    Vec3 index;
    for (unsigned d = 0; d < 3; ++d)
      index[d] = static_cast<double>((c >> d & 1) ? high_[d] + 1 : low_[d] - 1);
    const Vec3 x = volume_.position(index);
    box.low = c == 0 ? x : box.low.cwiseMin(x).eval();
    box.high = c == 0 ? x : box.high.cwiseMax(x).eval();
  }
  return box;
}

double LabelDomain::smallest_step() const {
  return volume_.axes.colwise().norm().minCoeff();
}

double LabelDomain::volume_of_body() const {
  return static_cast<double>(wanted_) * volume_.voxel_volume();
}

void LabelDomain::find_parts() {
  const std::int64_t n = volume_.size[0], m = volume_.size[1];
  std::vector<char> seen(volume_.voxels.size(), 0);
  std::vector<std::size_t> queue;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    const int label = subdomain_[volume_.voxels[start]];
    if (label == 0 || seen[start]) continue;
    queue.assign(1, start);
    seen[start] = 1;
    Part part{.at = {}, .subdomain = label};
    for (std::size_t q = 0; q < queue.size(); ++q) {
      const auto v = static_cast<std::int64_t>(queue[q]);
      const std::array<std::int64_t, 3> at{v % n, v / n % m, v / (n * m)};
      for (std::size_t d = 0; d < 3; ++d)
        for (const std::int64_t step : {-1, 1}) {
          std::array<std::int64_t, 3> to = at;
          to[d] += step;
          if (to[d] < 0 || to[d] >= volume_.size[d]) {
            part.touches_border = true;
            continue;
          }
          const std::size_t next = volume_.at(to[0], to[1], to[2]);
          if (seen[next] || subdomain_[volume_.voxels[next]] != label) continue;
          seen[next] = 1;
          queue.push_back(next);
        }
    }
    part.voxels = queue.size();
    const auto v = static_cast<std::int64_t>(queue[queue.size() / 2]);
    part.at = volume_.position(
        Vec3(static_cast<double>(v % n), static_cast<double>(v / n % m), static_cast<double>(v / (n * m))));
    parts_.push_back(part);
  }
}

std::vector<LabelDomain::Part> LabelDomain::seeded() const {
  std::map<int, std::size_t> largest;  // by subdomain
  for (const Part& part : parts_) {
    std::size_t& its = largest[part.subdomain];
    its = std::max(its, part.voxels);
  }
  std::vector<Part> result;
  for (const Part& part : parts_)
    if (part.voxels >= std::min(smallest_seeded, largest.at(part.subdomain))) result.push_back(part);
  return result;
}

// Towards the voxels of the same subdomain; `otherwise` where they lie on both sides, as in a sheet of one voxel.
Vec3 LabelDomain::inward(const std::array<std::int64_t, 3>& at, const Vec3& otherwise) const {
  const int own = voxel(at[0], at[1], at[2]);
  Vec3 sum = Vec3::Zero();
  for (std::int64_t k = -1; k <= 1; ++k)
    for (std::int64_t j = -1; j <= 1; ++j)
      for (std::int64_t i = -1; i <= 1; ++i)
        if (voxel(at[0] + i, at[1] + j, at[2] + k) == own)
          sum += volume_.axes * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
  return sum.norm() > 0.5 * smallest_step() ? sum.normalized() : otherwise;
}

std::vector<std::array<Vec3, 2>> LabelDomain::across_interfaces(double apart) const {
  struct Placed {
    Vec3 at, inward;
  };
  std::vector<std::array<Vec3, 2>> pairs;
  std::map<std::array<std::int64_t, 3>, std::vector<Placed>> grid;  // cells as wide as `apart`
  const auto is_free = [&](const Placed& p, const std::array<std::int64_t, 3>& cell) {
    for (std::int64_t k = -1; k <= 1; ++k)
      for (std::int64_t j = -1; j <= 1; ++j)
        for (std::int64_t i = -1; i <= 1; ++i) {
          const auto near = grid.find({cell[0] + i, cell[1] + j, cell[2] + k});
          if (near == grid.end()) continue;
          for (const Placed& q : near->second)
            if ((p.at - q.at).norm() < apart && p.inward.dot(q.inward) > 0) return false;
        }
    return true;
  };
  for (std::int64_t k = low_[2]; k <= high_[2]; ++k)
    for (std::int64_t j = low_[1]; j <= high_[1]; ++j)
      for (std::int64_t i = low_[0]; i <= high_[0]; ++i)
        for (unsigned side = 0; side < 6 && voxel(i, j, k) != 0; ++side) {
          const std::array<std::int64_t, 3> at{i, j, k};
          std::array<std::int64_t, 3> to = at, cell;
          to[side / 2] += side % 2 ? 1 : -1;
          if (voxel(to[0], to[1], to[2]) == voxel(i, j, k)) continue;
          const auto centre = [&](const std::array<std::int64_t, 3>& v) {
            return volume_.position(
                Vec3(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])));
          };
          const Vec3 from = centre(at), beyond = centre(to);
          const Placed place{0.5 * (from + beyond), inward(at, (from - beyond).normalized())};
          for (unsigned d = 0; d < 3; ++d)
            cell[d] = static_cast<std::int64_t>(std::floor(place.at[d] / apart));
          if (!is_free(place, cell)) continue;
          grid[cell].push_back(place);
          pairs.push_back({from, beyond});
        }
  return pairs;
}

}  // namespace forefeel
