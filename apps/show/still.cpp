#include "apps/show/still.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "apps/picture/label_image.hpp"
#include "apps/picture/palette.hpp"
#include "apps/show/still_legend.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {
namespace {

constexpr int width = 1180, height = 780, title_height = 40;
constexpr std::size_t most_triangles = 14'000;  // a finer surface is coarsened

std::string shaded(const std::string& colour, double light) {
  std::string out = "#";
  for (std::size_t i = 1; i < 7; i += 2)
    out += fmt::format(
        "{:02x}", std::clamp(static_cast<int>(std::stoi(colour.substr(i, 2), nullptr, 16) * light), 0, 255));
  return out;
}

// Parallel projection along the line of sight.
class Eye {
 public:
  explicit Eye(const ShowContent& content) {
    const ViewPoint view = view_of(content);
    constexpr double radians = std::numbers::pi / 180;
    const double a = view.azimuth * radians, e = view.elevation * radians;
    towards_ = Vec3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    right_ = Vec3(-std::sin(a), std::cos(a), 0);
    up_ = towards_.cross(right_);
    const Box box = extent_of(content);
    Vec2 low = Vec2::Constant(1e300), high = -low;
    for (int k = 0; k < 8; ++k) {
      Vec3 corner;
      for (int axis = 0; axis < 3; ++axis) corner[axis] = (k >> axis) & 1 ? box.high[axis] : box.low[axis];
      const Vec2 at(corner.dot(right_), corner.dot(up_));
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    const Vec2 span = (high - low).cwiseMax(1e-9);
    scale_ = std::min((legend_left - 70) / span.x(), (height - title_height - 50) / span.y());
    middle_ = 0.5 * (low + high);
  }
  Vec2 operator()(const Vec3& p) const {
    return {0.5 * legend_left + scale_ * (p.dot(right_) - middle_.x()),
            0.5 * (height + title_height) - scale_ * (p.dot(up_) - middle_.y())};
  }
  double depth(const Vec3& p) const { return p.dot(towards_); }  // rises towards the eye
  const Vec3& towards() const { return towards_; }
  double pixels(double metres) const { return scale_ * metres; }

 private:
  Vec3 towards_, right_, up_;
  Vec2 middle_;
  double scale_ = 1;
};

// Shapes that are drawn from the farthest to the nearest.
class Depths {
 public:
  void add(double depth, std::function<void(FlatPicture&)> draw) {
    all_.emplace_back(depth, std::move(draw));
  }
  void draw(FlatPicture& picture) {
    std::ranges::stable_sort(all_, {}, [](const auto& entry) { return entry.first; });
    for (const auto& [depth, shape] : all_) shape(picture);
  }

 private:
  std::vector<std::pair<double, std::function<void(FlatPicture&)>>> all_;
};

struct Coarse {
  std::vector<Vec3> nodes;
  std::vector<Role> role;
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> region;  // #triangles, or empty
};

// The surface, with nodes of one small cube joined if it has too many triangles for a picture.
Coarse coarse_surface(const ShownBody& body, const Box& extent) {
  if (body.triangles.size() <= most_triangles)
    return {body.nodes, body.role, body.triangles, body.regions.of_triangle};
  const double cube = extent.size().maxCoeff() / 90;
  std::map<std::array<int, 3>, NodeIndex> place;
  std::vector<NodeIndex> joined(body.nodes.size());
  Coarse coarse;
  std::vector<double> count;
  for (std::size_t i = 0; i < body.nodes.size(); ++i) {
    std::array<int, 3> cell{};
    for (unsigned axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<int>(std::floor(body.nodes[i][axis] / cube));
    const auto [found, fresh] = place.try_emplace(cell, static_cast<NodeIndex>(coarse.nodes.size()));
    if (fresh) coarse.nodes.emplace_back(Vec3::Zero()), coarse.role.push_back(Role::free), count.push_back(0);
    const NodeIndex to = found->second;
    joined[i] = found->second;
    coarse.nodes[to] += body.nodes[i];
    coarse.role[to] = std::max(coarse.role[to], body.role[i]);
    ++count[to];
  }
  for (std::size_t i = 0; i < coarse.nodes.size(); ++i) coarse.nodes[i] /= count[i];
  for (std::size_t k = 0; k < body.triangles.size(); ++k) {
    const Triangle& t = body.triangles[k];
    const Triangle own{joined[t[0]], joined[t[1]], joined[t[2]]};
    if (own[0] == own[1] || own[1] == own[2] || own[0] == own[2]) continue;
    coarse.triangles.push_back(own);
    if (!body.regions.of_triangle.empty()) coarse.region.push_back(body.regions.of_triangle[k]);
  }
  return coarse;
}

void add_body(const ShownBody& body, const Box& extent, const Eye& eye, double opacity, Depths& shapes) {
  const Coarse coarse = coarse_surface(body, extent);
  const Vec3 lamp = (eye.towards() + Vec3(0.2, -0.1, 0.5)).normalized();
  for (std::size_t k = 0; k < coarse.triangles.size(); ++k) {
    const Triangle& t = coarse.triangles[k];
    const std::size_t region = coarse.region.empty() ? 0 : coarse.region[k];
    std::array<Vec3, 3> p;
    Role role = Role::contact;
    bool clamped = true;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = coarse.nodes[t[i]];
      const Role own = coarse.role[t[i]];
      if (own != Role::contact) role = Role::free;
      clamped = clamped && own == Role::clamp;
    }
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const bool facing = normal.dot(eye.towards()) > 0;
    if (opacity >= 1 && !facing) continue;
    const double light = 0.55 + 0.45 * std::abs(normal.dot(lamp));
    const std::string colour = shaded(clamped                 ? ink("clamp")
                                      : role == Role::contact ? ink("contact")
                                      : region > 0            ? colour_of(palette_in_use(), region - 1)
                                                              : ink("body"),
                                      light);
    const double see = (facing ? 1 : 0.5) * opacity;
    shapes.add(eye.depth((p[0] + p[1] + p[2]) / 3), [=, &eye](FlatPicture& picture) {
      picture.polygon({eye(p[0]), eye(p[1]), eye(p[2])}, colour, see);
    });
  }
  for (std::size_t i = 0; i < coarse.nodes.size(); ++i) {
    if (coarse.role[i] == Role::free) continue;
    const bool contact = coarse.role[i] == Role::contact;
    const Vec3 at = coarse.nodes[i];
    shapes.add(eye.depth(at) + 1e-3 * extent.size().maxCoeff(), [=, &eye](FlatPicture& picture) {
      picture.dot(eye(at), contact ? 3.0 : 2.2, ink(contact ? "contact" : "clamp"));
    });
  }
}

// The springs of the pad: the contact's colour where they are strongest, the body's where they end.
void add_pad(const ShownBody& body, const Box& extent, const Eye& eye, Depths& shapes) {
  const ShownPad& pad = *body.pad;
  const Vec3 lamp = (eye.towards() + Vec3(0.2, -0.1, 0.5)).normalized();
  const auto place = [&](NodeIndex point) {
    const Triangle& t = body.triangles[pad.facet[point]];
    const Vec3& at = pad.at[point];
    return Vec3(at[0] * body.nodes[t[0]] + at[1] * body.nodes[t[1]] + at[2] * body.nodes[t[2]]);
  };
  for (const Triangle& t : pad.triangles) {
    const std::array<Vec3, 3> p{place(t[0]), place(t[1]), place(t[2])};
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    if (normal.dot(eye.towards()) <= 0) continue;
    const std::uint32_t facet = pad.facet[t[0]];
    const std::size_t region = body.regions.of_triangle.empty() ? 0 : body.regions.of_triangle[facet];
    const std::string& base = region > 0 ? colour_of(palette_in_use(), region - 1) : ink("body");
    const double share = (pad.weight[t[0]] + pad.weight[t[1]] + pad.weight[t[2]]) / 3;
    const std::string colour =
        shaded(mixed(base, ink("contact"), share), 0.55 + 0.45 * std::abs(normal.dot(lamp)));
    // at the depth of the facet, so that it is drawn on top of it
    const Triangle& own = body.triangles[facet];
    const Vec3 middle = (body.nodes[own[0]] + body.nodes[own[1]] + body.nodes[own[2]]) / 3;
    shapes.add(eye.depth(middle) + 1e-4 * extent.size().maxCoeff(), [=, &eye](FlatPicture& picture) {
      picture.polygon({eye(p[0]), eye(p[1]), eye(p[2])}, colour, 1);
    });
  }
}

// Where regions touch inside the body.
void add_inside(const ShownInterface& inside, const Eye& eye, Depths& shapes) {
  const Vec3 lamp = (eye.towards() + Vec3(0.2, -0.1, 0.5)).normalized();
  for (std::size_t k = 0; k < inside.triangles.size(); ++k) {
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = inside.nodes[inside.triangles[k][i]];
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const std::string colour =
        shaded(colour_of(palette_in_use(), inside.region[k]), 0.55 + 0.45 * std::abs(normal.dot(lamp)));
    shapes.add(eye.depth((p[0] + p[1] + p[2]) / 3), [=, &eye](FlatPicture& picture) {
      picture.polygon({eye(p[0]), eye(p[1]), eye(p[2])}, colour, 1);
    });
  }
}

void add_box(const Box& box, const Eye& eye, Depths& shapes) {
  for (int k = 0; k < 8; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      if ((k >> axis) & 1) continue;
      Vec3 from, to;
      for (int a = 0; a < 3; ++a) from[a] = (k >> a) & 1 ? box.high[a] : box.low[a];
      to = from;
      to[axis] = box.high[axis];
      constexpr int parts = 12;  // so that each part lies entirely before or behind other shapes
      for (int i = 0; i < parts; ++i) {
        const Vec3 a = from + (to - from) * (double(i) / parts),
                   b = from + (to - from) * (double(i + 1) / parts);
        shapes.add(eye.depth(0.5 * (a + b)),
                   [=, &eye](FlatPicture& picture) { picture.line(eye(a), eye(b), 1.1, "#444444"); });
      }
    }
}

// The plane of the labels that are shown: through rest, or the middle of the box; of x and y, the one that faces
// the eye more.
struct Cut {
  int axis = 0;
  double level = 0;  // [m]
};

Cut cut_of(const Eye& eye, const Box& box) {
  const int axis = std::abs(eye.towards().x()) > std::abs(eye.towards().y()) ? 0 : 1;
  return {axis, box.contains(Vec3::Zero()) ? 0 : box.centre()[axis]};
}

void add_plane(const LabelGrid& grid, const Box& box, const Eye& eye, Depths& shapes) {
  const int axis = cut_of(eye, box).axis;
  const double level = cut_of(eye, box).level;
  const int u = axis == 0 ? 1 : 0, v = 2;
  const std::array<std::size_t, 3> stride{1, grid.count[0], std::size_t{grid.count[0]} * grid.count[1]};
  Vec3 step;
  for (int a = 0; a < 3; ++a) step[a] = box.size()[a] / grid.count[static_cast<std::size_t>(a)];
  const auto count = [&](int a) { return static_cast<int>(grid.count[static_cast<std::size_t>(a)]); };
  const int layer =
      step[axis] > 0 ? std::clamp(static_cast<int>((level - box.low[axis]) / step[axis]), 0, count(axis) - 1)
                     : 0;
  const LabelImage image(count(u), count(v), [&](int column, int row) {
    return grid.label[static_cast<std::size_t>(layer) * stride[static_cast<std::size_t>(axis)] +
                      static_cast<std::size_t>(row) * stride[static_cast<std::size_t>(v)] +
                      static_cast<std::size_t>(column) * stride[static_cast<std::size_t>(u)]];
  });
  constexpr int longest = 6;  // of a run of cells, so that the order by depth holds
  for (int row = 0; row < image.rows; ++row)
    for (const LabelBox& run : label_runs(image, row, longest)) {
      std::array<Vec3, 4> corner;
      for (std::size_t k = 0; k < 4; ++k) {
        corner[k][axis] = level;
        corner[k][u] = box.low[u] + step[u] * (k == 1 || k == 2 ? run.right : run.left);
        corner[k][v] = box.low[v] + step[v] * (k >= 2 ? run.above : run.below);
      }
      shapes.add(eye.depth(0.5 * (corner[0] + corner[2])), [=, &eye](FlatPicture& picture) {
        picture.polygon({eye(corner[0]), eye(corner[1]), eye(corner[2]), eye(corner[3])}, colour(run.label),
                        run.label == Label::blank ? 0.6 : 1);
      });
    }
}

void add_states(const ShownStates& states, const Cut& cut, const Eye& eye, double spacing, Depths& shapes) {
  const double radius = std::clamp(0.16 * eye.pixels(spacing), 1.2, 4.0);
  for (const ShownState& s : states.all) {
    const Vec3 at = s.state.at;
    if (near_cut_only(states) && std::abs(at[cut.axis] - cut.level) > 0.5 * spacing) continue;
    const std::string& own = ink(!s.state.usable()         ? "failed"
                                 : s.label == Label::blank ? "blank_dot"
                                                           : name(s.label));
    shapes.add(eye.depth(at), [=, &eye](FlatPicture& picture) {
      picture.dot(eye(at), radius + 0.8, "#ffffff");
      picture.dot(eye(at), radius, own);
    });
  }
}

void add_run(const ShownRun& run, const Box& extent, const Eye& eye, Depths& shapes) {
  const std::size_t step = std::max<std::size_t>(1, run.path.size() / 1500);
  double strongest = 1e-12;
  for (const ShownFrame& f : run.path) strongest = std::max(strongest, f.sent.norm());
  for (std::size_t i = 0; i + step < run.path.size(); i += step) {
    const Vec3 a = run.path[i].at, b = run.path[i + step].at;
    shapes.add(eye.depth(0.5 * (a + b)),
               [=, &eye](FlatPicture& picture) { picture.line(eye(a), eye(b), 1.6, ink("path")); });
  }
  const std::size_t sparse = std::max<std::size_t>(1, run.path.size() / 40);
  for (std::size_t i = 0; i < run.path.size(); i += sparse) {
    const Vec3 a = run.path[i].at, force = 0.18 * extent.size().norm() / strongest * run.path[i].sent,
               b = a + force;
    if (force.norm() < 1e-3 * extent.size().norm()) continue;
    shapes.add(eye.depth(b), [=, &eye](FlatPicture& picture) {
      const Vec2 from = eye(a), to = eye(b);
      picture.line(from, to, 1.2, ink("force"), 0.8);
      const Vec2 along = to - from;
      if (along.norm() < 6) return;
      const Vec2 back = to - 6 * along.normalized(), side = 2.6 * Vec2(-along.y(), along.x()).normalized();
      picture.polygon({to, back + side, back - side}, ink("force"), 0.9);
    });
  }
}

// Directions of the axes, at the lower left.
void add_axes(const Eye& eye, FlatPicture& picture) {
  const Vec2 origin(60, height - 60), zero = eye(Vec3::Zero());
  constexpr std::array<const char*, 3> names{"x", "y", "z"}, inks{"axis_x", "axis_y", "axis_z"};
  for (int axis = 0; axis < 3; ++axis) {
    const Vec2 along = (eye(Vec3::Unit(axis)) - zero) / eye.pixels(1) * 38;
    const auto i = static_cast<std::size_t>(axis);
    picture.line(origin, origin + along, 1.8, ink(inks[i]));
    picture.text(origin + 1.3 * along + Vec2(-4, 4), names[i], 13, ink(inks[i]));
  }
}

}  // namespace

FlatPicture still_picture(const ShowContent& content) {
  FlatPicture picture(width, height);
  const Eye eye(content);
  const Box extent = extent_of(content);
  Depths shapes;
  const bool inside = content.body && !content.body->regions.inside.empty();
  const double opacity = content.states || content.run ? 0.22 : inside ? 0.35 : 1;
  if (content.body) add_body(*content.body, extent, eye, opacity, shapes);
  if (content.body && content.body->pad) add_pad(*content.body, extent, eye, shapes);
  if (inside) add_inside(content.body->regions.inside, eye, shapes);
  if (content.box) add_box(*content.box, eye, shapes);
  if (content.states) {
    if (!content.states->labels.empty()) add_plane(content.states->labels.back(), *content.box, eye, shapes);
    add_states(*content.states, cut_of(eye, *content.box), eye, content.spacing, shapes);
  }
  if (content.run) add_run(*content.run, extent, eye, shapes);
  shapes.draw(picture);
  picture.text({24, 28}, content.title, 16);
  add_legend(content, picture);
  add_axes(eye, picture);
  return picture;
}

}  // namespace forefeel
