// Sets by label on states that hardly determine a field: planes, a line, a lone state beside them. In such sets, adding
// or removing one state changes a polynomial term, a hull or a side.

#include "approx/model/updater.hpp"
#include "tests/approx/jumps.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

struct ThinSet {
  const char* name;
  StateSpace space;
};

StateSpace empty_space() {
  StateSpaceOptions options;
  options.spacing = h;
  return StateSpace(options);
}

void add_plane(StateSpace& space, int axis, double at, int half) {
  for (int i = -half; i <= half; ++i)
    for (int j = -half; j <= half; ++j) {
      Vec3 x;
      x[axis] = at;
      x[(axis + 1) % 3] = i * h;
      x[(axis + 2) % 3] = j * h;
      space.insert(field_state(x));
    }
}

std::vector<ThinSet> thin_sets() {
  std::vector<ThinSet> sets;
  const auto make = [&](const char* name, const auto& fill) {
    sets.push_back({name, empty_space()});
    fill(sets.back().space);
  };
  make("a plane and rest", [](StateSpace& s) {
    add_plane(s, 0, -0.024, 6);
    s.insert(field_state(Vec3::Zero()));
  });
  make("planes at a right angle", [](StateSpace& s) {
    add_plane(s, 0, -0.036, 5);
    add_plane(s, 2, -0.036, 5);
  });
  make("two planes", [](StateSpace& s) {
    add_plane(s, 0, -0.03, 5);
    add_plane(s, 0, 0.03, 5);
  });
  make("a plane and a block", [](StateSpace& s) {
    add_plane(s, 0, -0.042, 6);
    for (int i = 0; i < 3; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -2; k <= 2; ++k) s.insert(field_state(Vec3(0.042 + i * h, 0.018 + j * h, k * h)));
  });
  make("a plane and a line", [](StateSpace& s) {
    add_plane(s, 0, -0.03, 5);
    for (int i = -8; i <= 8; ++i) s.insert(field_state(Vec3(0.03, i * h, 0)));
  });
  make("a cube of 27, hardly more than a model takes", [](StateSpace& s) {
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) s.insert(field_state(h * Vec3(i, j, k)));
  });
  make("three small patches far apart", [](StateSpace& s) {
    for (const Vec3& corner : {Vec3(-0.12, -0.08, -0.12), Vec3(0.12, -0.08, 0.12), Vec3(-0.12, 0.08, 0.12)})
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) s.insert(field_state(corner + h * Vec3(i, j, 0)));
  });
  return sets;
}

const std::vector<ModelOptions> models = {
    {.kernel = Kernel::linear, .neighbours = 20},
    {.kernel = Kernel::quintic, .neighbours = 25},
    {.kernel = Kernel::cubic, .data = Data::force_and_stiffness, .neighbours = 16},
    {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25},
    {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 60},
    {.kernel = Kernel::cubic, .neighbours = 60, .ridge = 0.1},
    {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25, .ridge = 0.1}};

}  // namespace

TEST_CASE("By label: the force is continuous beside planes, lines and lone states",
          SLOW("walks past thin sets micrometre by micrometre")) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto anywhere = [&] { return Vec3(0.08 * unit(random), 0.05 * unit(random), 0.05 * unit(random)); };
  for (const ThinSet& set : thin_sets())
    for (const ModelOptions& options : models)
      for (int way = 0; way < 3; ++way) {
        const Vec3 from = anywhere(), to = anywhere();
        CAPTURE(set.name, name(options.kernel), name(options.data), options.neighbours, from.transpose(),
                to.transpose());
        ModelUpdater updater(set.space, options);
        const auto force = [&](const Vec3& x) {
          updater.forget();
          return updater.model_at(x).force(x);
        };
        const Jump jump = largest_jump(set.space, force, from, to, 4e-4, 3);
        CAPTURE(jump.at.transpose());
        CHECK(jump.finite);
        CHECK(jump.left < 1e-5 * std::max(1.0, force(to).norm()));
      }
}

// The state is so far from all others that no other state counts there.
TEST_CASE("By label: a lone state has its force, and what is beside it no other") {
  for (const double far : {0.05, 0.07, 0.12, 0.6, 6.0}) {
    StateSpace space = empty_space();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) space.insert(field_state(h * Vec3(i, j, k)));
    State lone = field_state(Vec3(0.03, 0.02, -0.01));
    lone.at = Vec3(0.018 + far, 0, 0);
    space.insert(lone);
    for (const ModelOptions& options : models)
      for (const std::size_t n : {std::size_t{4}, options.neighbours}) {
        if (options.ridge > 0) continue;  // smooths
        for (const double apart : {0.0, 1e-15, 1e-12, 1e-9, 1e-7}) {
          ModelOptions few = options;
          few.neighbours = n;
          CAPTURE(far, name(options.kernel), name(options.data), n, apart);
          ModelUpdater updater(space, few);
          const Vec3 x = lone.at + apart * Vec3(0.3, -1, 0.5);
          CHECK((updater.model_at(x).force(x) - lone.force).norm() <=
                1e-9 * (1 + lone.force.norm()) + 2000 * apart);
        }
      }
  }
}

// A position on the inner side of a corner, so near to a state that the direction to it is hardly defined. Its label is
// sparse.
TEST_CASE("By label: a state at the HIP counts fully, however little apart they are") {
  StateSpace space = empty_space();
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k) space.insert(field_state(h * Vec3(i, j, k)));
  space.insert(field_state(Vec3(0.06, 0.01, 0)));
  int outside_safe = 0;
  for (const ModelOptions& options : models) {
    if (options.ridge > 0) continue;  // smooths
    for (const Vec3& corner : {Vec3(-0.012, -0.012, -0.012), Vec3(0.012, -0.012, 0.012), Vec3(0.06, 0.01, 0)})
      for (const double apart : {0.0, 5e-13, 2e-12, 1e-9, 1e-6, 1e-5})
        for (const Vec3& way :
             std::vector<Vec3>{Vec3(1, 1, 1), Vec3(1, 0, 0), Vec3(-1, 0.2, 0.3), Vec3(-1, 0, 0)}) {
          const Vec3 x = corner + apart * way;
          ModelUpdater updater(space, options);
          const Vec3 force = updater.model_at(x).force(x);
          CAPTURE(name(options.kernel), options.neighbours, corner.transpose(), apart, way.transpose());
          outside_safe += space.label(x) != Label::safe ? 1 : 0;
          // No stiffness of the field is above 400 N/m here; r alone has a kink at every state.
          CHECK((force - field_state(corner).force).norm() < 1e-9 + 2000 * apart * way.norm());
        }
  }
  CHECK(outside_safe > 100);
}
