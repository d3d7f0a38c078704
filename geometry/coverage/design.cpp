#include "geometry/coverage/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>

#include "geometry/common/error.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {
namespace {

constexpr std::array<std::string_view, 6> names{"lattice",  "body-centred", "halton",
                                                "farthest", "error",        "list"};

// Radical inverse of i with its digits permuted: the permutation of a digit depends on the digits before it, so every
// prefix stays as even as it was.
double scrambled_inverse(std::uint64_t i, unsigned base, std::uint64_t seed) {
  double value = 0, digit = 1;
  std::uint64_t before = seed * 0x9e3779b97f4a7c15ULL + base;
  for (int k = 0; digit > 1e-15 && k < 60; ++k, i /= base) {
    std::array<unsigned, 5> order{0, 1, 2, 3, 4};
    std::mt19937_64 random(before);
    for (unsigned a = base - 1; a > 0; --a) std::swap(order[a], order[random() % (a + 1)]);
    const unsigned read = static_cast<unsigned>(i % base);
    digit /= base;
    value += digit * order[read];
    before = before * 0xbf58476d1ce4e5b9ULL + read + 1;
  }
  return value;
}

std::vector<Vec3> halton_places(const Box& box, std::size_t n, std::uint64_t seed) {
  std::vector<Vec3> places;
  for (std::uint64_t i = 0; i < n; ++i) {
    const Vec3 share(scrambled_inverse(i, 2, seed), scrambled_inverse(i, 3, seed),
                     scrambled_inverse(i, 5, seed));
    places.push_back(box.low + box.size().cwiseProduct(share));
  }
  return places;
}

std::vector<Vec3> farthest_places(const Box& box, std::size_t n, std::uint64_t seed) {
  const std::vector<Vec3> all = halton_places(box, 16 * n, seed);
  std::vector<double> squared(all.size(), std::numeric_limits<double>::infinity());
  std::vector<Vec3> places{box.contains(Vec3::Zero()) ? Vec3(Vec3::Zero()) : all.front()};
  while (places.size() < n) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      squared[i] = std::min(squared[i], (all[i] - places.back()).squaredNorm());
      if (squared[i] > squared[farthest]) farthest = i;
    }
    places.push_back(all[farthest]);
  }
  return places;
}

std::vector<Vec3> body_centred_places(const Box& box, double spacing) {
  const double side = std::cbrt(2.0) * spacing;
  const Vec3 half = Vec3::Constant(0.5 * side);
  std::vector<Vec3> places = lattice(box, side);
  for (const Vec3& at : lattice({box.low - half, box.high - half}, side)) places.push_back(at + half);
  return places;
}

}  // namespace

std::string_view name(Design design) {
  return names[static_cast<std::size_t>(design)];
}

std::vector<std::string> design_names() {
  return {names.begin(), names.end() - 1};
}

std::size_t design_size(const Box& box, double spacing) {
  return static_cast<std::size_t>(
      std::max(1.0, std::round(box.size().prod() / (spacing * spacing * spacing))));
}

std::vector<Vec3> designed_places(const StateSpaceOptions& space, std::uint64_t seed) {
  const auto& [box, spacing, design] = std::tie(space.box, space.spacing, space.design);
  if (design == Design::lattice) return lattice(box, spacing);
  if (design == Design::listed) return space.listed ? *space.listed : std::vector<Vec3>{};
  if (design == Design::error)
    throw InputError(
        "state_space.design",
        "is \"error\", which places each state by those solved before it: of generate. A session "
        "chooses so by its policy; expected another design");
  const std::size_t n = design_size(box, spacing);
  std::vector<Vec3> places = design == Design::body_centred ? body_centred_places(box, spacing)
                             : design == Design::halton     ? halton_places(box, n, seed)
                                                            : farthest_places(box, n, seed);
  if (design == Design::halton && box.contains(Vec3::Zero())) places.front().setZero();
  const auto outward = [](const Vec3& at) { return std::tuple(at.squaredNorm(), at.x(), at.y(), at.z()); };
  std::ranges::sort(places, {}, outward);
  return places;
}

void check_listed(const StateSpaceOptions& space, const std::string& file) {
  const auto shown = [&](std::size_t i) {
    const Vec3& at = (*space.listed)[i];
    return fmt::format("place {} at ({:g}, {:g}, {:g})", i + 1, at.x(), at.y(), at.z());
  };
  PointOctree known;
  for (std::size_t i = 0; i < space.listed->size(); ++i) {
    const Vec3& at = (*space.listed)[i];
    if (!space.box.contains(at))
      throw InputError({.file = file},
                       shown(i) + " lies outside the box, expected places [m] in state_space.box");
    const auto near = known.nearest(at, space.merge_distance * space.spacing);
    if (near.id != PointOctree::nobody)
      throw InputError({.file = file},
                       fmt::format("{} is {} again, expected each place once", shown(i), shown(near.id)));
    known.insert(static_cast<std::uint32_t>(i), at);
  }
}

}  // namespace forefeel
