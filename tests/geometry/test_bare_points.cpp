// Points without forces: what a table tells, and the spacing of a cloud.

#include <random>

#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<State> states_at(const std::vector<Vec3>& places) {
  std::vector<State> states(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) states[i].at = places[i];
  return states;
}

std::vector<Vec3> random_places(std::size_t n, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> places(n);
  for (Vec3& at : places)
    for (int k = 0; k < 3; ++k) at[k] = uniform(engine);
  return places;
}

}  // namespace

TEST_CASE("a table of places tells of places, of one value each, or of forces") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return read_table_csv(folder.write("t.csv", text)); };
  for (const char* text : {"1,2,3\n4,5,6\n", "z,y,x\n3,2,1\n6,5,4\n", "x,y,z,h\n1,2,3,0.1\n4,5,6,0.1\n"}) {
    CAPTURE(text);
    const StateTable table = read(text);
    CHECK(table.tells == Tells::places);
    REQUIRE(table.states.size() == 2);
    CHECK(table.states[1].at == Vec3(4, 5, 6));
    CHECK(!table.states[1].force.allFinite());
    CHECK(table.states[1].usable());
  }
  for (const char* text : {"1,2,3,-7\n", "x,y,z,temperature\n1,2,3,-7\n", "E,x,y,z\n-7,1,2,3\n"}) {
    CAPTURE(text);
    const StateTable table = read(text);
    CHECK(table.tells == Tells::value);
    CHECK(table.states.at(0).at == Vec3(1, 2, 3));
    CHECK(table.states.at(0).force == Vec3(-7, 0, 0));
  }
  CHECK(read("x,y,z,fx,fy,fz\n1,2,3,4,5,6\n").tells == Tells::force);
  const auto refused = [&](const std::string& text) { return error_of([&] { read(text); }); };
  CHECK_THAT(refused("x,y,z,fx\n1,2,3,4\n"), Contains("t.csv:1: no column fy"));
  CHECK_THAT(refused("x,y,z,a,b\n1,2,3,4,5\n"), Contains("no column fx", "with one value"));
  CHECK_THAT(refused("1,2,3,4,5,6\n"), Contains("no column x"));
  CHECK_THAT(refused("1,2,3\n4,5\n"), Contains("t.csv:2: 2 columns, expected 3"));
  CHECK_THAT(refused("x,y,z,v\n1,2,3,\n"), Contains("t.csv:2: column v"));
}

TEST_CASE("who needs forces is told that a file has none, a state file keeps what its table told") {
  const TemporaryFolder folder;
  const auto kept = [&](const std::string& text, const char* tells) {
    const StateTable table = read_table_csv(folder.write("t.csv", text));
    StateFileHeader header;
    header.spacing = 1;
    header.box = {table.states[0].at, table.states[0].at + Vec3::Ones()};
    header.notes[tells_note] = tells;
    StateFile::open_or_create(folder / "t.states", header).replace(header, table.states);
    return folder / "t.states";
  };
  auto file = kept("1,2,3\n4,5,6\n", "places");
  CHECK(load_states(file, Tells::places).tells == Tells::places);
  CHECK(load_states(file, Tells::places).states.size() == 2);
  CHECK_THAT(error_of([&] { load_states(file); }), Contains("t.states: holds places alone", "fx,fy,fz"));
  file = kept("1,2,3,9\n", "value");
  CHECK(load_states(file, Tells::value).states.at(0).force.x() == 9);
  CHECK_THAT(error_of([&] { load_states(file); }), Contains("holds one value at each place"));
  // Without the note a missing force is damage, as before.
  kept("1,2,3\n", "places");
  StateFileHeader header;
  header.spacing = 1;
  header.box = {Vec3::Zero(), Vec3::Ones()};
  StateFile::open_or_create(folder / "t.states", header).replace(header, states_at({Vec3::Zero()}));
  CHECK_THAT(error_of([&] { load_states(folder / "t.states"); }), Contains("force that is not finite"));
}

TEST_CASE("the estimated spacing is that of the density, not of the closest pairs") {
  const double h = 0.01;
  const std::vector<Vec3> full = lattice({Vec3::Zero(), Vec3::Constant(12 * h)}, h);
  CHECK(estimate_spacing(states_at(full)) == Approx(h).epsilon(1e-9));
  // Jittered by up to a quarter of the side.
  std::vector<Vec3> jittered = full;
  const std::vector<Vec3> shares = random_places(full.size(), 3);
  for (std::size_t i = 0; i < full.size(); ++i) jittered[i] += 0.5 * h * (shares[i] - Vec3::Constant(0.5));
  CHECK(estimate_spacing(states_at(jittered)) == Approx(h).epsilon(0.1));
  // Random places: about nine tenths of a place's neighbourhood must be dense, so h is 1.1 to 1.35 n^(-1/3).
  for (const std::size_t n : {500, 4000}) {
    const double found = estimate_spacing(states_at(random_places(n, 5))) * std::cbrt(double(n));
    CHECK(found > 1.1);
    CHECK(found < 1.35);
  }
  // Two clusters far apart: their own density, not the distance of the clusters.
  std::vector<Vec3> clusters = full;
  for (const Vec3& at : full) clusters.push_back(at + Vec3(5, 0, 0));
  CHECK(estimate_spacing(states_at(clusters)) == Approx(h).epsilon(1e-6));
  // On a surface, flat or curved, the spacing is that along it: the side of a square lattice, and at random, of n
  // places an area, Gamma(9/2) / Gamma(4) / sqrt(pi n) = 1.094 n^(-1/2), the mean distance to the fourth nearest.
  std::vector<Vec3> square, plane = random_places(2000, 7), sphere = random_places(3000, 8);
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) square.push_back(h * Vec3(i, 0.6 * j, 0.8 * j));
  CHECK(estimate_spacing(states_at(square)) == Approx(h).epsilon(1e-9));
  for (Vec3& at : plane) at.z() = 0.2 * at.x();
  CHECK(estimate_spacing(states_at(plane)) ==
        Approx(1.094 * std::sqrt(std::sqrt(1.04) / 2000)).epsilon(0.06));
  for (Vec3& at : sphere) {
    const double z = 2 * at.z() - 1, turn = 2 * M_PI * at.x(), across = std::sqrt(1 - z * z);
    at = {across * std::cos(turn), across * std::sin(turn), z};
  }
  CHECK(estimated_spacing(states_at(sphere)).dimension == 2);
  CHECK(estimate_spacing(states_at(sphere)) == Approx(1.094 * std::sqrt(4 * M_PI / 3000)).epsilon(0.06));
  CHECK(estimated_spacing(states_at(full)).dimension == 3);
  CHECK(estimated_spacing(states_at(random_places(100, 9))).dimension == 3);
  // Along a stroke: its step.
  std::vector<Vec3> stroke;
  for (int i = 0; i < 100; ++i) stroke.push_back(Vec3(1, 2, 3) * (h * i / std::sqrt(14.0)));
  CHECK(estimate_spacing(states_at(stroke)) == Approx(h).epsilon(1e-6));
  CHECK(std::isnan(estimate_spacing(states_at({Vec3::Zero()}))));
}
