#include "approx/model/model_options.hpp"
#include "approx/model/neighbours.hpp"
#include "approx/model/updater.hpp"
#include "tests/approx/jumps.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

// Lattice layers i in [first, last] along x.
StateSpace slab(const std::vector<std::pair<int, int>>& layers, int half = 6) {
  StateSpaceOptions options;
  options.spacing = h;
  options.box = {Vec3::Constant(-20 * h), Vec3::Constant(20 * h)};
  StateSpace space(options);
  for (const auto& [first, last] : layers)
    for (int i = first; i <= last; ++i)
      for (int j = -half; j <= half; ++j)
        for (int k = -half; k <= half; ++k) space.insert(field_state(Vec3(i * h, j * h, k * h)));
  return space;
}

const std::vector<ModelOptions> models = {
    {.kernel = Kernel::linear, .neighbours = 100},
    {.kernel = Kernel::cubic, .neighbours = 100},
    {.kernel = Kernel::quintic, .neighbours = 100},
    {.kernel = Kernel::cubic, .data = Data::force_and_stiffness, .neighbours = 25},
    {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25}};

}  // namespace

TEST_CASE("nearest takes the n nearest; no state gives the zero model") {
  const StateSpace empty = slab({});
  ModelUpdater none(empty, {});
  Model model;
  CHECK_FALSE(none.update(Vec3::Zero(), model));
  CHECK(model.force(Vec3(0.01, 0, 0)).norm() == 0);
  CHECK(model.serial() == 0);

  const StateSpace space = slab({{-3, 3}});
  for (const std::size_t n : {1, 7, 30}) {
    ModelUpdater updater(space, {.neighbours = n, .select = Select::nearest});
    std::uint64_t serial = 0;
    for (double x = -0.01; x < 0.01; x += 0.0011) {
      const Vec3 hip(x, 0.4 * x + 1e-4, -x + 3e-4);
      UpdateReport report;
      REQUIRE(updater.update(hip, model, &report));
      CHECK(report.n == n);
      CHECK(model.serial() > serial);
      serial = model.serial();
      double farthest = 0;
      std::set<std::uint32_t> in;
      for (const StateId id : model.states()) {
        farthest = std::max(farthest, (space[id].at - hip).norm());
        in.insert(id.value);
      }
      CHECK(in.size() == n);
      for (std::uint32_t i = 0; i < space.size(); ++i)
        if (!in.contains(i)) CHECK((space[{i}].at - hip).norm() >= farthest * (1 - 1e-12));
    }
  }
}

TEST_CASE("An updater that follows a path gives what a new one gives, and forget() makes it exact") {
  const StateSpace space = slab({{-6, 6}});
  for (ModelOptions options : models) {
    CAPTURE(name(options.kernel), name(options.data));
    options.select = Select::nearest;
    ModelUpdater kept(space, options), other(space, options);
    Model a, b;
    for (double t = 0; t < 6; t += 0.07) {
      const Vec3 hip(0.02 * std::sin(t), 0.015 * std::cos(1.3 * t), 0.01 * std::sin(0.7 * t));
      kept.update(hip, a);
      other.forget();
      other.update(hip, b);
      CHECK((a.force(hip) - b.force(hip)).norm() < 1e-9);
      ModelUpdater fresh(space, options);
      CHECK(fresh.model_at(hip).force(hip) == b.force(hip));
    }
  }
}

TEST_CASE("By label: a gap has both sides in balance, and crossing it shows no jump above the JND") {
  const StateSpace space = slab({{-10, -4}, {4, 10}});  // 48 mm between the fronts
  for (const ModelOptions& options : models) {
    CAPTURE(name(options.kernel), name(options.data));
    ModelUpdater updater(space, options);
    Model before, now;
    std::set<Label> seen;
    double worst = 0;
    std::size_t left_most = 0, right_most = 0;
    for (double x = -5 * h; x <= 5 * h; x += 0.25 * h) {
      const Vec3 hip(x, 0.013, 0.0021);
      UpdateReport report;
      updater.update(hip, now, &report);
      seen.insert(report.label);
      std::size_t left = 0, right = 0;
      for (const StateId id : now.states()) ++(space[id].at[0] < 0 ? left : right);
      if (std::abs(x) < 1e-9) {
        CHECK(left + right <= most_neighbours(options));
        CHECK(left + right >= options.neighbours);
        NeighbourSelector selector(space, options);
        std::vector<Neighbour> chosen;
        selector.select(hip, chosen);
        double weight[2] = {};
        for (const Neighbour& c : chosen) weight[space[c.id].at[0] < 0 ? 0 : 1] += c.weight;
        CHECK(std::abs(weight[0] - weight[1]) <= 0.2 * (weight[0] + weight[1]));
      }
      left_most = std::max(left_most, left);
      right_most = std::max(right_most, right);
      if (before.serial() > 0) {
        const Vec3 old = before.force(hip), fresh = now.force(hip);
        worst = std::max(worst, (fresh - old).norm() / std::max(fresh.norm(), 0.010 / 0.07));
      }
      std::swap(before, now);
    }
    CHECK(seen.contains(Label::gap));
    CHECK(left_most >= options.neighbours);
    CHECK(right_most >= options.neighbours);
    CHECK(worst < 0.07);
  }
}

// Jump = |M_i(x_i) - M_{i-1}(x_i)| over steps of 0.1 mm, M_i the model that belongs to x_i.
TEST_CASE("By label: however wide a gap is, crossing it shows no jump above the JND, forwards as backwards",
          SLOW("crosses gaps millimetre by millimetre")) {
  for (const int half_gap : {5, 7, 10})
    for (const ModelOptions& options : models)
      for (const double offset : {0.0, 0.013}) {
        if (options.kernel == Kernel::linear && half_gap > 7) continue;  // one layer only, that far
        const bool many = options.neighbours == 100 && options.kernel != Kernel::cubic;
        if (many && (offset > 0 || half_gap < 7)) continue;  // to be quick
        CAPTURE(half_gap, name(options.kernel), name(options.data), offset);
        const StateSpace space = slab({{-half_gap - 6, -half_gap}, {half_gap, half_gap + 6}});
        ModelUpdater updater(space, options), back(space, options);
        Model before, now, other;
        double worst = 0;
        int step = 0;
        for (double x = -(half_gap + 1) * h; x <= (half_gap + 1) * h; x += 1e-4, ++step) {
          const Vec3 hip(x, offset, 0.16 * offset);
          updater.update(hip, now);
          const Vec3 fresh = now.force(hip);
          if (before.serial() > 0) {
            const double jump = (fresh - before.force(hip)).norm();
            worst = std::max(worst, jump / std::max(0.07 * fresh.norm(), 0.010));
          }
          if (step % 100 == 50 && space.label(hip) != Label::safe) {  // the set depends on the HIP alone
            back.update(hip + Vec3(0.003, 0.001, 0), other);
            back.update(hip, other);
            CHECK(other.force(hip) == fresh);
          }
          std::swap(before, now);
        }
        CHECK(worst < 1);
      }
}

// Two blocks of 5 x 7 x 7 states. Beside the gap, above its edges and on slanted paths, no coordinate axis separates
// the sides, and few neighbours without stiffness do not always determine the polynomial.
TEST_CASE("By label: nothing jumps anywhere in, beside or above a gap, with however few neighbours",
          SLOW("crosses gaps millimetre by millimetre")) {
  const std::vector<std::pair<Vec3, Vec3>> ways = {{{0.001, 0, 0.002}, {0.001, 0.06, 0.002}},
                                                   {{0, 0, 0.002}, {0, 0.06, 0.002}},
                                                   {{0.001, 0, 0.002}, {0.001, 0.05, 0.045}},
                                                   {{-0.06, -0.03, 0.002}, {0.06, 0.03, -0.012}},
                                                   {{-0.05, 0.0013, 0.0021}, {0.05, 0.0013, 0.0021}}};
  for (const double gap : {0.036, 0.048}) {
    StateSpaceOptions in;
    in.spacing = h;
    StateSpace space(in);
    for (const int side : {-1, 1})
      for (int i = 0; i <= 4; ++i)
        for (int j = -3; j <= 3; ++j)
          for (int k = -3; k <= 3; ++k)
            space.insert(field_state(Vec3(side * (0.5 * gap + i * h), j * h, k * h)));
    for (ModelOptions options : models)
      for (const std::size_t n : {20, 25}) {
        options.neighbours = n;
        CAPTURE(gap, name(options.kernel), name(options.data), n);
        ModelUpdater updater(space, options);
        const auto force = [&](const Vec3& x) {
          updater.forget();
          return updater.model_at(x).force(x);
        };
        for (const auto& [from, to] : ways) {
          const Jump jump = largest_jump(space, force, from, to, 2e-4, 1);
          CAPTURE(jump.at.transpose());
          CHECK(jump.finite);
          CHECK(jump.left < 1e-5);
        }
      }
  }
}

TEST_CASE("By label: of however few neighbours, moving before a flat face shows no jump above the JND",
          SLOW("crosses gaps millimetre by millimetre")) {
  const StateSpace space = slab({{-10, -4}}, 8);
  for (ModelOptions options : models)
    for (const std::size_t n : {4, 8, 13}) {
      options.neighbours = n;
      CAPTURE(name(options.kernel), name(options.data), n);
      ModelUpdater updater(space, options);
      double worst = 0;
      for (const double out : {1.5, 2.5, 4.0}) {
        Model before, now;
        for (double y = -0.5 * h; y <= 0.5 * h; y += 1e-4) {
          const Vec3 hip((-4 + out) * h, y, 0.3 * y + 0.001);
          updater.update(hip, now);
          CHECK(now.states().size() <= most_neighbours(options));
          const Vec3 fresh = now.force(hip);
          if (before.serial() > 0)
            worst =
                std::max(worst, (fresh - before.force(hip)).norm() / std::max(0.07 * fresh.norm(), 0.010));
          std::swap(before, now);
        }
      }
      CHECK(worst < 1);
    }
}

TEST_CASE("By label: in a blank area the set is a half ball of the boundary, not a layer") {
  const StateSpace space = slab({{-10, -4}}, 8);
  for (const ModelOptions& options : models) {
    CAPTURE(name(options.kernel), name(options.data));
    for (const double out : {2.1, 4.0, 10.0}) {
      ModelUpdater updater(space, options);
      Model model;
      UpdateReport report;
      const Vec3 hip((-4 + out) * h, 0.001, -0.0013);
      updater.update(hip, model, &report);
      CHECK(report.label == Label::blank);
      CHECK(model.kernel() == options.kernel);  // no step down
      std::set<long> layers;
      for (const StateId id : model.states()) layers.insert(std::lround(space[id].at[0] / h));
      CHECK(layers.size() >= (options.neighbours < 50 ? 2u : 3u));
      CHECK(model.force(hip).norm() <= model.force_bound());
    }
  }
}

TEST_CASE("Sets have hysteresis: trembling about a place changes nothing") {
  const StateSpace space = slab({{-6, 6}});
  ModelUpdater updater(space, models[1]);
  Model model;
  UpdateReport report;
  std::size_t replaced = 0;
  for (int i = 0; i < 200; ++i) {
    const double t = 5e-5 * (i % 2 == 0 ? 1 : -1);
    updater.update(Vec3(t, 0.4 * h + t, -0.3 * h - t), model, &report);
    if (i > 2) replaced += report.replaced;
  }
  CHECK(replaced == 0);
}

TEST_CASE("New states are taken up") {
  StateSpace space = slab({{-6, -4}});
  ModelUpdater updater(space, models[4]);
  Model model;
  const Vec3 hip(0.3 * h, 0.2 * h, -0.1 * h), exact = field_state(hip).force;
  updater.update(hip, model);
  const double before = (model.force(hip) - exact).norm();
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (int k = -3; k <= 3; ++k) {
        space.insert(field_state(Vec3(i * h, j * h, k * h)));
        updater.update(hip, model);
        CHECK(model.force(hip).allFinite());
        CHECK(model.force(hip).norm() <= model.force_bound());
      }
  CHECK((model.force(hip) - exact).norm() < 1e-3 * before);
}
