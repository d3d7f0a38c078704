// What is said of rows that somebody else measured: heaps, signs, offsets, units.
#include "geometry/mesh/length_unit.hpp"
#include "geometry/states/heaps.hpp"
#include "geometry/states/misleading.hpp"
#include "tests/support/test.hpp"

namespace {

// f = -K x (1 + |x|^2 / c), K = diag(250, 250, 420) N/m, of a clamped body that stiffens.
Vec3 pushed(const Vec3& x) {
  return -Vec3(250, 250, 420).cwiseProduct(x) * (1 + 0.35 * x.squaredNorm() / 4e-4);
}

std::vector<State> rows_of(std::size_t n, unsigned seed, const std::function<Vec3(const Vec3&)>& force,
                           const Vec3& sides = Vec3::Constant(0.02), double noise = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1, 1);
  std::normal_distribution<double> normal(0, 1);
  std::vector<State> rows(n);
  for (State& row : rows) {
    row.at = sides.cwiseProduct(Vec3(share(random), share(random), share(random)));
    row.force = force(row.at);
    for (int axis = 0; axis < 3; ++axis) row.force[axis] += noise * normal(random);
  }
  return rows;
}

std::string said(const std::vector<State>& rows) {
  std::string text;
  for (const std::string& line : misleading(rows, 0.004)) text += line + "\n";
  return text;
}

}  // namespace

TEST_CASE("forces on the tissue in place of those on the tip are said, with the columns that turn them") {
  const auto turned = [](const Vec3& x) { return Vec3(-pushed(x)); };
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO(seed);
    const double noise = 0.02 * seed;
    const Vec3 sides = seed % 3 == 1   ? Vec3(0.02, 0.01, 0)
                       : seed % 3 == 2 ? Vec3(0.03, 0, 0)
                                       : Vec3(0.02, 0.02, 0.02);
    CHECK(said(rows_of(60, seed, pushed, sides, noise)).empty());
    CHECK_THAT(said(rows_of(60, seed, turned, sides, noise)),
               Contains("the forces pull where an elastic body pushes back") &&
                   Contains("--columns x,y,z,-fx,-fy,-fz"));
  }
  // Axes of the sensor exchanged or turned.
  const auto exchanged = [](const Vec3& x) { return Vec3(pushed(x).z(), pushed(x).x(), pushed(x).y()); };
  CHECK_THAT(said(rows_of(60, 3, exchanged)), Contains("--columns x,y,z,fy,fz,fx"));
  const auto half_turn = [](const Vec3& x) { return Vec3(-pushed(x).x(), -pushed(x).y(), pushed(x).z()); };
  CHECK_THAT(said(rows_of(60, 3, half_turn)), Contains("--columns x,y,z,-fx,-fy,fz"));
}

TEST_CASE("a force in one direction alone has a sign, and forces turned about it are said") {
  for (unsigned seed = 0; seed < 6; ++seed) {
    INFO(seed);
    const auto press = [](const Vec3& x) { return Vec3(0, 0, -600 * x.z()); };
    const auto pull = [](const Vec3& x) { return Vec3(0, 0, 600 * x.z()); };
    CHECK(said(rows_of(60, seed, press, Vec3::Constant(0.02), 0.02 * seed)).empty());
    CHECK_THAT(said(rows_of(60, seed, pull, Vec3::Constant(0.02), 0.02 * seed)),
               Contains("--columns x,y,z,-fx,-fy,-fz"));
    const auto quarter = [](const Vec3& x) { return Vec3(-pushed(x).y(), pushed(x).x(), pushed(x).z()); };
    CHECK_THAT(said(rows_of(60, seed, quarter)), Contains("--columns x,y,z,fy,-fx,fz"));
  }
}

TEST_CASE("one far row is named, and not the unit of all") {
  std::vector<State> rows = rows_of(60, 1, pushed);
  rows[41].at = Vec3(3.6, -0.2, 0.1);
  CHECK_THAT(said(rows), Contains("row 42 at 3.6,-0.2,0.1 m is far from all others") && !Contains("metres"));
  rows[41].at = Vec3(0.3, -0.2, 0.1);
  CHECK_THAT(said(rows), Contains("row 42 at 0.3,-0.2,0.1 m is far from all others"));
  rows[41].at = Vec3(0.09, 0.01, 0);
  CHECK_THAT(said(rows), !Contains("far from all others"));
  for (State& row : rows) row.at *= 1000;
  rows[41].at = rows[40].at;
  CHECK_THAT(said(rows), Contains("expected metres"));
}

TEST_CASE("a force at rest within the noise of the rows is no tare") {
  std::size_t said_of = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<State> rows = rows_of(60, seed, pushed, Vec3(0, 0, 0.01), 0.3);
    rows.insert(rows.begin(), State());
    rows.front().force = Vec3(0.3, -0.3, 0.2);
    said_of += Contains("at rest").match(said(rows));
    rows.front().force = Vec3(0, 0, 3);
    CHECK_THAT(said(rows), Contains("at rest"));
  }
  CHECK(said_of == 0);
}

TEST_CASE("nothing is said of forces without a trend, or of a body that only softens") {
  const auto chance = [](const Vec3& x) {
    return Vec3(std::sin(1e5 * x[0]), std::cos(9e4 * x[1]), std::sin(8e4 * x[2]));
  };
  CHECK_THAT(said(rows_of(60, 1, chance)), !Contains("pull"));
  const auto softening = [](const Vec3& x) { return Vec3(-200 * x * (1 - 0.3 * x.squaredNorm() / 4e-4)); };
  CHECK(said(rows_of(60, 1, softening)).empty());
}

TEST_CASE("a force at rest is said: a sensor that was not tared") {
  std::vector<State> rows = rows_of(40, 2, [](const Vec3& x) { return Vec3(pushed(x) + Vec3(0, 0, 1.5)); });
  CHECK(said(rows).empty());  // no row at rest tells
  rows.emplace_back();
  rows.back().at.setZero();
  rows.back().force = Vec3(0, 0, 1.5);
  CHECK_THAT(said(rows), Contains("the force at rest (0,0,0) is 0,0,1.5 N, expected 0"));
  rows.back().force = Vec3(0, 0, 0.005);
  CHECK_THAT(said(rows), !Contains("rest"));
}

TEST_CASE("one column in another unit is said by its axis") {
  std::vector<State> rows = rows_of(40, 2, pushed);
  for (State& row : rows) row.at.y() *= 1000;
  CHECK_THAT(said(rows), Contains("along y and at most 0.0"));
}

TEST_CASE("time for x is said; lattices, rasters and strokes are not taken for it") {
  const auto clock = [](double from, double step) {
    std::vector<State> rows = rows_of(90, 5, pushed);
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].at.x() = from + step * double(i);
    return rows;
  };
  constexpr auto word = "from row to row, as a clock does";
  CHECK_THAT(said(clock(0, 0.001)), Contains("x rises by 0.001 from row to row, as a clock does"));
  CHECK_THAT(said(clock(1.25, 0.004)), Contains(word));
  std::vector<State> shuffled = clock(0, 0.001);
  std::swap(shuffled[3], shuffled[50]);
  CHECK_THAT(said(shuffled), !Contains(word));
  const auto quiet = [&](std::size_t count, const std::function<Vec3(std::size_t)>& at) {
    std::vector<State> rows(count);
    for (std::size_t i = 0; i < count; ++i) rows[i].at = at(i), rows[i].force = pushed(rows[i].at);
    CHECK_THAT(said(rows), !Contains(word));
  };
  const double step = 0.004;
  for (const unsigned slow :
       {1u, 10u, 100u})  // x as the slowest, the middle and the quickest axis of a lattice
    quiet(1000, [&](std::size_t i) {
      const auto at = [&](unsigned by) { return step * double(i / by % 10); };
      return Vec3(at(slow),
                  at(slow == 1    ? 10
                     : slow == 10 ? 100
                                  : 1),
                  at(slow == 1    ? 100
                     : slow == 10 ? 1
                                  : 10));
    });
  const auto there_and_back = [&](std::size_t i) { return step * double(i / 10 % 2 ? 9 - i % 10 : i % 10); };
  quiet(200, [&](std::size_t i) { return Vec3(step * double(i / 10), there_and_back(i), 0); });
  quiet(200, [&](std::size_t i) { return Vec3(there_and_back(i), step * double(i / 10), 0); });
  quiet(50, [&](std::size_t i) { return Vec3(0.001 * double(i), 0, 0); });  // a stroke
  quiet(50, [&](std::size_t i) { return Vec3(0.001 * double(i), 0.0005 * double(i), 0.01); });
  quiet(50,
        [&](std::size_t i) { return Vec3(0.001 * double(i), 1e-5 * double(i % 3), 0); });  // that trembles
  quiet(50, [&](std::size_t i) { return Vec3(0.001 * double(i), 0, 0.01 * std::sin(0.06 * double(i))); });
}

TEST_CASE("a stiffness that is 0 but for rounding is printed as 0") {
  std::vector<State> rows(60);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-0.02, 0.02);
  for (State& row : rows) {
    row.at = Vec3(share(random), share(random), share(random));
    row.force = Vec3(0, 0, 300 * row.at.z());
  }
  CHECK_THAT(said(rows), Contains("-300 to 0 N/m"));
}

TEST_CASE("a dwell counts as one place; other rows, lines and repeated scans stay as they are") {
  std::mt19937 random(4);
  std::normal_distribution<double> tremor(0, 5e-5);
  for (unsigned variant = 0; variant < 10; ++variant) {
    INFO(variant);
    std::vector<State> rows = rows_of(60, variant, pushed);
    const std::size_t dwell = 100 + 100 * variant;
    const Vec3 place = 0.01 * Vec3(std::sin(variant), std::cos(variant), 0.3);
    for (std::size_t i = 0; i < dwell; ++i) {
      State row;
      row.at = place + Vec3(tremor(random), tremor(random), tremor(random));
      row.force = pushed(row.at);
      rows.push_back(row);
    }
    if (variant % 2) std::ranges::shuffle(rows, random);
    const JoinedHeaps joined = join_heaps(rows);
    CHECK(joined.heaps >= 1);
    CHECK(joined.rows + 5 > dwell);
    CHECK(joined.states.size() <= 60 + 5);
    for (const State& state : joined.states) CHECK((state.force - pushed(state.at)).norm() < 2e-3);
    CHECK_THAT(said(rows), !Contains("far from those of all neighbours"));
  }
  CHECK(join_heaps(rows_of(400, 1, pushed)).heaps == 0);
  CHECK(join_heaps(rows_of(400, 1, pushed, Vec3(0.02, 0, 0))).heaps == 0);
  std::vector<State> twice = rows_of(50, 1, pushed), again;
  for (const State& row : twice)
    for (int k = 0; k < 30; ++k) again.push_back(row);
  CHECK(join_heaps(again).heaps == 0);
  CHECK(thinned_heaps(again).size() == again.size());
  for (const std::size_t count : {60, 400, 2000})
    CHECK(thinned_heaps(rows_of(count, 1, pushed)).size() == count);
  for (std::size_t i = 0; i < 3; ++i) twice[i].at = Vec3(1, 2, double(i));  // a tracker that was lost
  CHECK(thinned_heaps(twice).size() == twice.size());
}

TEST_CASE("a dwell with a wide tremor counts as few rows where rows are counted; all others stay, in order") {
  std::mt19937 random(5);
  for (unsigned variant = 0; variant < 10; ++variant) {
    INFO(variant);
    std::normal_distribution<double> tremor(0, 2e-4 * (variant + 1));
    const std::vector<State> places = rows_of(60, variant, pushed);
    std::vector<State> rows = places;
    for (std::size_t i = 0; i < 400; ++i) {
      rows.push_back(places.front());
      rows.back().at = Vec3(0.004, -0.006, 0.002) + Vec3(tremor(random), tremor(random), tremor(random));
    }
    const std::vector<State> kept = thinned_heaps(rows);
    CHECK(kept.size() < 60 + 40);
    const auto far = [](const State& row) { return (row.at - Vec3(0.004, -0.006, 0.002)).norm() > 0.015; };
    std::vector<State> wanted, found;
    std::ranges::copy_if(rows, std::back_inserter(wanted), far);
    std::ranges::copy_if(kept, std::back_inserter(found), far);
    CHECK(std::ranges::equal(found, wanted, {}, &State::at, &State::at));
  }
}

TEST_CASE("units of length are known in any spelling") {
  for (const char* word : {"um", "\xC2\xB5m", "\xCE\xBCm", "\xB5m", "micron", "microns", "Microns",
                           "micrometer", "micrometers", "micrometre", "Micrometres"})
    CHECK(unit_of(word) == 1e-6);
  for (const char* word : {"mm", "MM", "millimeter", "millimeters", "Millimetres"})
    CHECK(unit_of(word) == 1e-3);
  for (const char* word : {"cm", "centimeter", "centimetres"}) CHECK(unit_of(word) == 1e-2);
  for (const char* word : {"m", "meter", "metres"}) CHECK(unit_of(word) == 1);
  for (const char* word : {"nm", "nanometers"}) CHECK(unit_of(word) == 1e-9);
  for (const char* word : {"", "inch", "furlong", "mmm", "pixel"}) CHECK_FALSE(unit_of(word));
  CHECK(unit_name(1e-6) == "um");
}
