// Tables of states that contradict themselves: stiffness of the other sign or unit, positions in millimetres. Each is
// tried on ten variants of a seed: other axes, sizes, stiffnesses, noise, order of rows.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "geometry/common/types.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/stiffness_agreement.hpp"
#include "tests/support/executable.hpp"

namespace {

// A field f = -A x - c |x|^2 x with its exact stiffness; the force has noise.
struct Field {
  std::mt19937 random;
  double scale;
  Mat3 linear;
  std::vector<State> states;

  explicit Field(unsigned seed, double noise) : random(seed) {
    scale = std::pow(10.0, real(-2.5, -0.5));  // [m]
    const Mat3 turn = Eigen::Quaterniond(real(-1, 1), real(-1, 1), real(-1, 1), real(0.1, 1))
                          .normalized()
                          .toRotationMatrix();
    const double stiff = std::pow(10.0, real(1, 4));
    linear = turn * Vec3(stiff, real(0.2, 3) * stiff, real(0.2, 3) * stiff).asDiagonal() * turn.transpose();
    const double cubic = real(0, 2) * stiff / (scale * scale);
    const auto count = static_cast<std::size_t>(real(20, 150));
    const double most = linear.norm() * scale;
    for (std::size_t i = 0; i < count; ++i) {
      State& state = states.emplace_back();
      state.at = scale * Vec3(real(-1, 1), real(-1, 1), real(-1, 1));
      const Vec3& x = state.at;
      state.force = -linear * x - cubic * x.squaredNorm() * x +
                    noise * most * Vec3(real(-1, 1), real(-1, 1), real(-1, 1));
      state.stiffness = linear + cubic * (x.squaredNorm() * Mat3::Identity() + 2 * x * x.transpose());
      state.solve.status = SolveStatus::measured;
    }
  }
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
};

std::string csv(const std::vector<State>& states, double unit = 1) {
  std::string text = "x,y,z,fx,fy,fz,k11,k12,k13,k21,k22,k23,k31,k32,k33\n";
  for (const State& s : states) {
    const Vec3 x = s.at / unit;
    const Mat3 k = (unit * s.stiffness).transpose();  // column by column: rows of K
    text += fmt::format("{},{},{},{},{},{},{}\n", x[0], x[1], x[2], s.force[0], s.force[1], s.force[2],
                        fmt::join(std::span(k.data(), 9), ","));
  }
  return text;
}

std::string said(const std::vector<State>& states) {
  return disagreement_in_words(stiffness_agreement(states));
}

}  // namespace

TEST_CASE("stiffness of the other sign is said, whatever the field, the noise and the share of rows") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Field field(seed, seed % 2 == 0 ? 0 : 0.05);
    CHECK(said(field.states).empty());
    std::vector<State> wrong = field.states;
    for (State& state : wrong) state.stiffness = -state.stiffness.eval();
    CHECK_THAT(said(wrong), Contains("has the other sign", "expected K = -df/dx"));
    std::shuffle(wrong.begin(), wrong.end(), field.random);
    CHECK_THAT(said(wrong), Contains("has the other sign"));
    // A third of the rows from another source.
    std::vector<State> mixed = field.states;
    for (std::size_t i = 0; i < mixed.size(); i += 3) mixed[i].stiffness = -mixed[i].stiffness.eval();
    CHECK_THAT(said(mixed), Contains("has the other sign"));
    // N/mm beside m.
    std::vector<State> unit = field.states;
    for (State& state : unit) state.stiffness /= 1000;
    CHECK_THAT(said(unit), Contains("times what the forces of neighbouring states show"));
    // A single row of the other sign; none where noise hides it.
    std::vector<State> one = field.states;
    one[one.size() / 2].stiffness = -one[one.size() / 2].stiffness.eval();
    if (seed % 2 == 0) CHECK_THAT(said(one), Contains("has the other sign", " 1 of "));
    // Rows and columns in another order, and no stiffness at all though forces change.
    std::vector<State> permuted = field.states, zero = field.states;
    for (State& state : permuted) {
      const Mat3 k = state.stiffness;
      state.stiffness << k.row(1), k.row(2), k.row(0);
    }
    for (State& state : zero) state.stiffness.setZero();
    if (seed % 2 == 0) CHECK(!said(permuted).empty());
    if (seed % 2 == 0) CHECK_THAT(said(zero), Contains("is 0 at"));
    // Without stiffness, with one state, and where a state alone has stiffness, there is nothing to say.
    for (State& state : unit) state.stiffness.setConstant(unknown);
    CHECK(said(unit).empty());
    CHECK(said({}).empty());
    CHECK(said({field.states.front()}).empty());
  }
}

TEST_CASE(
    "a force that is far from all its neighbours is named with its place, and a kink, a step or noise is "
    "not") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int seed = 0; seed < 10; ++seed) {
    const double noise = seed % 2 == 0 ? 0 : 0.02;
    std::vector<State> line(300);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const double x = 1e-4 * (double(i) - 150);
      line[i].at = Vec3(x, 0.3 * x, -0.003);
      line[i].force =
          Vec3(-60 * x, std::abs(40 * x), x > 0 ? 3 : 0) + noise * Vec3(normal(random), normal(random), 0);
    }
    CHECK(misleading(line, 1e-3).empty());
    const std::size_t bad = 40 + 20 * std::size_t(seed);
    line[bad].force += Vec3(0, 50, 0);
    const std::vector<std::string> lines = misleading(line, 1e-3);
    REQUIRE(lines.size() == 1);
    CHECK_THAT(lines[0], Catch::StartsWith("1 force is far from those of all neighbours, at ") &&
                             Contains(fmt::format("{:g},", line[bad].at[0]), "by 50 N"));
    for (State& state : line) state.at *= 1000;
    CHECK_THAT(fmt::format("{}", fmt::join(misleading(line, 1e-3), "; ")),
               Contains("the states span 29.9 m", "--unit cm, mm"));
  }
  CHECK(misleading({}, 1e-3).empty());
  CHECK(misleading(std::vector<State>(5), unknown).empty());
}

TEST_CASE("noise that hides the change between neighbours is no contradiction") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Field field(seed, 0);
    // A press that is held: positions within a millionth of the scale, forces that scatter.
    for (State& state : field.states) {
      state.at = Vec3(field.scale, 0, 0) + 1e-6 * state.at;
      state.force = 0.01 * field.linear.norm() * field.scale *
                    Vec3(field.real(-1, 1), field.real(-1, 1), field.real(-1, 1));
    }
    INFO("seed " << seed << ": " << said(field.states));
    CHECK(said(field.states).empty());
  }
}

TEST_CASE("import and evaluate say that the sign of the stiffness contradicts the forces") {
  const Workshop shop;
  shop.write("points.csv", "x,y,z\n0.001,0,0\n");
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Field field(seed, seed % 3 == 0 ? 0.02 : 0);
    const auto spacing = fmt::format("--spacing {:.3g}", 0.3 * field.scale);
    const std::string name = fmt::format("s{}.states", seed);
    shop.write("right.csv", csv(field.states));
    if (seed % 3 == 0) {
      const auto right = shop.run("import right.csv -o right" + name + " " + spacing);
      CHECK_THAT(right.err, !Contains("warning"));
    }
    for (State& state : field.states) state.stiffness = -state.stiffness.eval();
    shop.write("wrong.csv", csv(field.states));
    const auto imported = shop.run("import wrong.csv -o wrong" + name + " " + spacing);
    CHECK_THAT(imported.err, Contains("wrong.csv: the stiffness (k11 to k33) has the other sign"));
    if (seed > 1) continue;
    const auto evaluated = shop.forefeel("evaluate wrong" + name + " --points points.csv --no-bars");
    CHECK_THAT(evaluated.err, Contains("the stiffness (k11 to k33) has the other sign"));
  }
}

TEST_CASE("states in millimetres are imported with --unit, and without it their size is said") {
  const Workshop shop;
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Field field(seed, 0.01);
    const char* const names[] = {"cm", "mm", "um"};
    const double metres[] = {1e-2, 1e-3, 1e-6};
    const unsigned which = seed % 3;
    const auto spacing = fmt::format("--spacing {:.3g}", 0.3 * field.scale);
    shop.write("other.csv", csv(field.states, metres[which]));
    const std::string base = fmt::format("import other.csv -o {}.states {}", seed, spacing);
    CHECK_THAT(shop.forefeel(base).err, Contains("or --unit cm, mm or um"));
    const auto taken = shop.run(base + " --unit " + names[which]);
    CHECK_THAT(taken.err, !Contains("warning"));
    const std::vector<State> states = load_states(shop.path() / fmt::format("{}.states", seed)).states;
    REQUIRE(states.size() == field.states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
      CHECK((states[i].at - field.states[i].at).norm() < 1e-12 * field.scale);
      CHECK((states[i].stiffness - field.states[i].stiffness).norm() <
            1e-10 * field.states[i].stiffness.norm());
      CHECK(states[i].force == field.states[i].force);
    }
  }
  CHECK(shop.forefeel("import other.csv -o x.states --spacing 0.01 --unit inch").code == 2);
}

TEST_CASE("loading and unloading rows of the same places are named as hysteresis alone") {
  const Workshop shop;
  std::string text = "x,y,z,fx,fy,fz\n";
  for (int stroke = 0; stroke < 4; ++stroke)
    for (int i = 1; i <= 20; ++i) {
      const int depth = stroke % 2 ? 21 - i : i;
      text += fmt::format("0,0,{},0,0,{}\n", -0.001 * depth, (stroke % 2 ? 0.3 : 0.4) * depth);
    }
  shop.write("loop.csv", text);
  for (const char* command : {"info loop.csv", "import loop.csv -o loop.states --spacing 0.002"}) {
    INFO(command);
    const std::string said = shop.forefeel(command).err;
    CHECK_THAT(said, Contains("hysteresis: loading and unloading") && !Contains("contradict") &&
                         !Contains("duplicate"));
  }
}
