// Workers in the ranks of an MPI run, where the build has them.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "tests/support/executable.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/skip.hpp"

using forefeel::test::beam_scene;
using forefeel::test::Workshop;

namespace {

Workshop::Outcome ranks(const Workshop& shop, int count, const std::string& arguments) {
  return shop.shell(
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpirun --oversubscribe -n " +
      std::to_string(count) + " " + forefeel::test::executable() + " " + arguments);
}

}  // namespace

TEST_CASE("a session with its workers in other processes") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome alone = shop.forefeel("session beam.toml --mpi --clock real --seconds 1 -o alone");
  CHECK(alone.code == 2);
  CHECK(alone.error_lines() == 1);
  if (alone.err.find("no MPI") != std::string::npos) return forefeel::test::skip("this build has no MPI");
  if (!forefeel::test::has_command("mpirun")) return forefeel::test::skip("mpirun is not installed");
  CHECK(alone.err.find("one rank") != std::string::npos);

  const Workshop::Outcome run =
      ranks(shop, 3, "session beam.toml --mpi --clock real --seconds 1.5 -o run --json --quiet");
  INFO(run.err);
  REQUIRE(run.code == 0);
  const nlohmann::json summary = run.json();
  CHECK(summary["workers"] == 2);
  CHECK(summary["states"]["solved"] > 10);
  CHECK(summary["error"]["within_jnd"] > 0.5);

  // What the ranks solved, against the tight solve of one process.
  const auto solved = shop.shell(
      "awk -F, 'NR > 1 && NR < 12 {print $1\",\"$2\",\"$3}' run/states.csv | (echo x,y,z; cat) > points.csv");
  REQUIRE(solved.code == 0);
  const nlohmann::json tight = shop.forefeel("solve beam.toml --points points.csv --json").json();
  std::istringstream rows(shop.shell("tail -n +2 run/states.csv").out);
  std::size_t compared = 0;
  for (std::string row; compared < tight["states"].size() && std::getline(rows, row); ++compared) {
    std::istringstream cells(row);
    double v[6], difference = 0, size = 0;
    for (double& number : v) {
      std::string cell;
      std::getline(cells, cell, ',');
      number = std::stod(cell);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const double force = tight["states"][compared]["force"][i];
      difference += std::pow(v[3 + i] - force, 2);
      size += force * force;
    }
    CHECK(std::sqrt(difference) <= 1e-5 * std::sqrt(size) + 1e-9);
  }
  CHECK(compared == 10);

  CHECK(ranks(shop, 3, "session beam.toml --mpi --clock virtual -o other")
            .err.find("no use under the virtual clock") != std::string::npos);
  CHECK(ranks(shop, 2, "session nothing.toml --mpi -o other").err.find("no such file") != std::string::npos);
  CHECK(
      ranks(shop, 3, "session beam.toml --mpi --clock real --workers 7 -o other").err.find("2 other ranks") !=
      std::string::npos);
  CHECK(shop.shell("test -e other").code != 0);
}
