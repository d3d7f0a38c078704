// Sites of states in state files, CSV files and messages: bit for bit, beside states without one and with jets.

#include "geometry/states/state_message.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

namespace {

State sited(int i, bool jet) {
  State s = state(i);
  s.displacements.reset();
  s.site = Vec3(0.01 * i, 1.0 / 3, -1e-9 * i);
  if (!jet) return s;
  EnergyJet own{.order = 3, .limit = 0.02};
  for (std::size_t k = 0; k < jet_terms_of_order(3); ++k)
    own.coefficients[k] = 1.5 * static_cast<double>(k) - i;
  s.jet = std::make_shared<const EnergyJet>(own);
  return s;
}

void check_same(const std::vector<State>& found, const std::vector<State>& wanted) {
  REQUIRE(found.size() == wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].at == wanted[i].at);
    CHECK(found[i].has_site() == wanted[i].has_site());
    if (wanted[i].has_site()) CHECK(found[i].site == wanted[i].site);
    REQUIRE((found[i].jet != nullptr) == (wanted[i].jet != nullptr));
    if (wanted[i].jet) CHECK(found[i].jet->coefficients == wanted[i].jet->coefficients);
  }
}

std::string refusal(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return error_of([&] { read_states_csv(file); });
}

}  // namespace

TEST_CASE("a state file takes sites at any time, before and after jets") {
  const std::vector<State> all{state(1), sited(2, false), sited(3, true), state(4)};
  const TemporaryFolder folder;
  for (const std::vector<std::size_t>& order :
       std::vector<std::vector<std::size_t>>{{0, 1, 2, 3}, {2, 0, 1, 3}, {1, 2, 3, 0}}) {
    const auto file = folder / (std::to_string(order[0]) + ".states");
    std::vector<State> wanted;
    {
      StateFile states = StateFile::open_or_create(file, header());
      for (const std::size_t i : order) wanted.push_back(all[i]), states.append({&all[i], 1});
    }
    const StateFile read = StateFile::open_read_only(file);
    check_same(read.read_all(), wanted);
    CHECK(read.damaged() == 0);
  }
}

TEST_CASE("a CSV of states has the columns of sites where some state has one") {
  const TemporaryFolder folder;
  const std::vector<State> all{state(1), sited(2, true), sited(5, false)};
  write_states_csv(folder / "s.csv", all);
  check_same(read_states_csv(folder / "s.csv"), all);
  write_states_csv(folder / "plain.csv", std::vector<State>{state(1)});
  std::string line;
  std::getline(std::ifstream(folder / "plain.csv") >> std::ws, line);
  CHECK_THAT(line, !Contains("sx"));
  CHECK_THAT(refusal(folder / "a.csv", "sx,sy,x,y,z,fx,fy,fz\n0,0,0,0,0,0,0,0\n"),
             Contains("2 of the columns sx, sy, sz"));
  CHECK_THAT(refusal(folder / "b.csv", "sx,sy,sz,x,y,z,fx,fy,fz\n0,,0,0,0,0,0,0,0\n"),
             Contains("the site is not a place"));
  std::ofstream(folder / "p.csv") << "x,y,z,sx,sy,sz\n1,2,3,4,5,6\n";
  const std::vector<SitedPoint> points = read_sited_points_csv(folder / "p.csv");
  REQUIRE(points.size() == 1);
  CHECK(points[0].site == Vec3(4, 5, 6));
  CHECK(points[0].at == Vec3(1, 2, 3));
  std::ofstream(folder / "q.csv") << "x,y,z\n1,2,3\n";
  CHECK_THAT(error_of([&] { read_sited_points_csv(folder / "q.csv"); }), Contains("no column sx"));
}

TEST_CASE("a message of a state carries its site") {
  for (const State& s : {sited(3, true), sited(4, false), state(6)}) {
    Packer out;
    pack(out, s);
    Unpacker in(out.take());
    check_same({unpack_state(in)}, {s});
    CHECK(in.left() == 0);
  }
}
