#include "scheduling/motion/path_shapes.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

// Distance from rest to the border of the box along a direction [m]. If rest is outside the box: a quarter of
// the box's largest side.
double reach_along(const Box& box, const Vec3& direction) {
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (direction[i] > 1e-12) distance = std::min(distance, box.high[i] / direction[i]);
    if (direction[i] < -1e-12) distance = std::min(distance, box.low[i] / direction[i]);
  }
  const double size = box.size().maxCoeff();
  return distance > 0 && std::isfinite(distance) ? distance : 0.25 * size;
}

// Axes of the hand (w into the body, u and v along its surface), and the extent of the box along each [m]. The seed is
// for drawn targets.
struct HandAxes {
  Vec3 u, v, w;
  double u_low, u_high, v_low, v_high, depth;
  std::uint64_t seed;

  // The point at fractions of these extents: a along u and b along v in [-1, 1], c along w in [0, 1].
  Vec3 at(double a, double b, double c) const {
    return (a < 0 ? -a * u_low : a * u_high) * (a < 0 ? Vec3(-u) : u) +
           (b < 0 ? -b * v_low : b * v_high) * (b < 0 ? Vec3(-v) : v) + c * depth * w;
  }
};

HandAxes axes_of_hand(const FactoryContext& context) {
  HandAxes f;
  f.w = context.inward.norm() > 0 ? Vec3(context.inward.normalized()) : Vec3(-Vec3::UnitZ());
  int axis = 0;
  f.w.cwiseAbs().minCoeff(&axis);
  f.u = (Vec3::Unit(axis) - f.w[axis] * f.w).normalized();
  f.v = f.w.cross(f.u);
  f.depth = reach_along(context.box, f.w);
  f.u_low = reach_along(context.box, -f.u);
  f.u_high = reach_along(context.box, f.u);
  f.v_low = reach_along(context.box, -f.v);
  f.v_high = reach_along(context.box, f.v);
  f.seed = context.seed;
  return f;
}

PathShape press(const HandAxes& f) {
  return {{Vec3::Zero()}, {Vec3::Zero(), f.at(0, 0, 0.8)}};
}

PathShape line(const HandAxes& f) {
  return {{Vec3::Zero(), f.at(0, 0, 0.4)}, {f.at(0, 0, 0.4), f.at(0.8, 0, 0.4), f.at(-0.8, 0, 0.4)}};
}

PathShape circle(const HandAxes& f) {
  PathShape shape{{Vec3::Zero(), f.at(0, 0, 0.5)}, {}};
  const double radius = 0.7 * std::min({f.u_low, f.u_high, f.v_low, f.v_high});
  for (int i = 0; i < 180; ++i) {
    const double angle = random::two_pi * i / 180;
    shape.loop.push_back(f.at(0, 0, 0.5) + radius * (std::cos(angle) * f.u + std::sin(angle) * f.v));
  }
  return shape;
}

PathShape lissajous(const HandAxes& f) {
  PathShape shape{{Vec3::Zero(), f.at(0, 0, 0.4)}, {}};
  for (int i = 0; i < 720; ++i) {
    const double angle = random::two_pi * i / 720;
    shape.loop.push_back(
        f.at(0.75 * std::sin(3 * angle), 0.75 * std::sin(2 * angle), 0.4 + 0.35 * std::sin(5 * angle)));
  }
  return shape;
}

// Moves from target to target; 16 random targets in the box.
PathShape reach_targets(const HandAxes& f) {
  PathShape shape{{Vec3::Zero()}, {}};
  for (std::uint64_t i = 0; i < 16; ++i) {
    const auto draw = [&](std::uint64_t k) { return random::uniform(random::mix(f.seed, 3 * i + k)); };
    shape.loop.push_back(f.at(1.6 * draw(0) - 0.8, 1.6 * draw(1) - 0.8, 0.1 + 0.75 * draw(2)));
  }
  return shape;
}

// Nine sites on a grid: at each, press in and come out, then move along the surface to the next.
PathShape palpation(const HandAxes& f) {
  PathShape shape{{Vec3::Zero()}, {Vec3::Zero(), f.at(0, 0, 0.7), Vec3::Zero()}};
  for (int row = -1; row <= 1; ++row)
    for (int i = -1; i <= 1; ++i) {
      const double a = 0.6 * (row % 2 == 0 ? i : -i), b = 0.6 * row;
      for (const double depth : {0.05, 0.7, 0.05}) shape.loop.push_back(f.at(a, b, depth));
    }
  return shape;
}

// Presses in, slides sideways out of the box and back, slides the other way, comes out.
PathShape tour(const HandAxes& f) {
  return {{Vec3::Zero()},
          {Vec3::Zero(), f.at(0, 0, 0.65), f.at(0.6, 0.1, 0.6), f.at(1.2, 0.2, 0.55), f.at(0.6, 0.5, 0.5),
           f.at(-0.2, 0.7, 0.5), f.at(-0.7, 0.2, 0.65), f.at(-0.4, -0.6, 0.45), f.at(0.3, -0.5, 0.3)}};
}

// Parallel lines over the box and a little beyond, layer by layer into the body.
PathShape mower(const HandAxes& f) {
  PathShape shape{{Vec3::Zero()}, {}};
  const int lines = 6;
  for (const double depth : {0.2, 0.5, 0.8})
    for (int i = 0; i < lines; ++i) {
      const double b = -0.9 + 1.8 * i / (lines - 1), side = i % 2 == 0 ? -1.15 : 1.15;
      shape.loop.push_back(f.at(side, b, depth));
      shape.loop.push_back(f.at(-side, b, depth));
    }
  return shape;
}

// Close parallel lines over the whole box, layer by layer into the body: the path visits nearly every lattice
// cell, most of them once. It is about 5 m long in a box of 7 cm.
PathShape raster(const HandAxes& f) {
  PathShape shape{{Vec3::Zero()}, {}};
  constexpr int lines = 12, layers = 5;
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i < lines; ++i) {
      const double b = (layer % 2 == 0 ? 1 : -1) * (-0.92 + 1.84 * i / (lines - 1)),
                   side = i % 2 == 0 ? -1.05 : 1.05;
      shape.loop.push_back(f.at(side, b, 0.1 + 0.2 * layer));
      shape.loop.push_back(f.at(-side, b, 0.1 + 0.2 * layer));
    }
  return shape;
}

}  // namespace

namespace {
struct NamedShape {
  PathShape (*curve)(const HandAxes&);
  std::string_view words;
};
// In the order of PathName.
constexpr NamedShape shapes[] = {
    {press, "straight in to 0.8 of the box's depth, and out"},
    {line, "from side to side at 0.4 of the depth"},
    {circle, "round rest at half the depth, 0.7 of the box's half width"},
    {lissajous, "a curve of frequencies 3, 2 and 5 that fills the middle of the box"},
    {reach_targets, "straight from one to the next of 16 targets drawn from the seed"},
    {palpation, "presses at nine places of a grid, lifts and moves on"},
    {tour, "in, sideways out of the box and back, and out"},
    {mower, "six parallel lines on each of three depths, a little beyond the box"},
    {raster, "twelve close parallel lines on each of five depths: nearly every place once"}};
}  // namespace

std::string_view path_in_words(PathName path) {
  return shapes[static_cast<std::size_t>(path)].words;
}

PathShape path_shape(PathName path, const FactoryContext& context) {
  return shapes[static_cast<std::size_t>(path)].curve(axes_of_hand(context));
}

}  // namespace forefeel
