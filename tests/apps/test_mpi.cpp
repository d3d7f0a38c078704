// Commands on the ranks of an MPI run, if the build has MPI: their results, and ranks that hang or die.

#include "tests/support/executable.hpp"

namespace {

const std::string as_root = "export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1; ";
// Open MPI leaves memory behind in modules that it unloads: its leaks are not looked for.
const std::string run = std::string(sanitized ? "ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0 " : "") +
                        "timeout -k 5 300 mpirun --oversubscribe ";

Workshop::Outcome ranks(const Workshop& shop, int count, const std::string& arguments) {
  return shop.shell(as_root + run + "-n " + std::to_string(count) + " '" + executable() + "' " + arguments);
}

// The same; rank 1 gets the signal as soon as the condition holds. Rank 0 leaves its exit code in code.0: that of
// mpirun is an error where a rank had to be ended.
Workshop::Outcome ranks_but_one(const Workshop& shop, const std::string& options,
                                const std::string& condition, const std::string& signal,
                                const std::string& arguments) {
  shop.write("rank.sh",
             "if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then\n"
             "  (exec >/dev/null 2>&1; p=$$; " +
                 wait_until(condition) + "kill -" + signal +
                 " $$) &\nfi\n"
                 "[ \"$OMPI_COMM_WORLD_RANK\" = 0 ] || exec '" +
                 executable() + "' " + arguments + "\n'" + executable() + "' " + arguments +
                 "\ncode=$?; echo $code >code.0; exit $code\n");
  return shop.shell(as_root + run + options + " bash rank.sh");
}

std::string code_of_rank_0(const Workshop& shop) {
  return shop.read("code.0");
}

// timeout(1) did not have to end it.
bool ended_by_itself(const Workshop::Outcome& outcome) {
  return outcome.code != 124 && outcome.code != 137;
}

// MPI begins once in a process, so this is one of its own.
Workshop::Outcome started_alone(const Workshop& shop) {
  return shop.shell("'" + executable() + "' session beam.toml --mpi --clock real --seconds 1 -o alone");
}

// The reason why these tests cannot run; empty if they can.
std::string reason_to_skip(const Workshop& shop) {
  shop.write("beam.toml", beam_scene());
  const auto alone = started_alone(shop);
  if (alone.err.find("no MPI") != std::string::npos) return "this build has no MPI";
  return has_command("mpirun") ? "" : "mpirun is not installed";
}

// All states of a file, sorted, without what depends on time.
std::string states_of(const Workshop& shop, const std::string& file) {
  const auto exported = shop.run("export " + file + " -o " + file + ".csv --quiet");
  return shop.shell("sort " + file + ".csv").out;
}

}  // namespace

TEST_CASE("generate by two ranks gives the states of generate by threads, and resumes",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  const std::string finer = " --set state_space.spacing=0.002 ";
  shop.run("generate beam.toml --threads 2 -o threads.states" + finer);
  const std::string expected = states_of(shop, "threads.states");
  const auto both = ranks(shop, 2, "generate beam.toml --mpi -o ranks.states --json --quiet" + finer);
  INFO(both.err);
  REQUIRE(both.code == 0);
  CHECK(both.json()["states"] == 125);
  CHECK(both.json()["ranks"]["lost"] == 0);
  CHECK(states_of(shop, "ranks.states") == expected);
  const auto again = ranks(shop, 1, "generate beam.toml --mpi -o ranks.states --json --quiet" + finer);
  REQUIRE(again.code == 0);
  CHECK(again.json()["resumed"] == 125);
  CHECK(again.json()["solved"] == 0);
  const auto both_ways = ranks(shop, 2, "generate beam.toml --mpi --error 0.1 -o other.states");
  CHECK(both_ways.code == 2);
  CHECK_THAT(both_ways.err, Contains("forefeel: --mpi: has no use with --error"));
  CHECK(both_ways.err.find("forefeel:") == both_ways.err.rfind("forefeel:"));
  CHECK(!shop.has("other.states"));
}

TEST_CASE("a rank of generate that is stopped, or killed where MPI allows, costs nothing but its own work",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  const std::string finer =
      " --set state_space.spacing=0.0004 ";  // seconds of work, longer than a signal is late
  shop.run("generate beam.toml --threads 2 -o threads.states" + finer);
  const std::string expected = states_of(shop, "threads.states");
  const auto stopped = ranks_but_one(shop, "-n 3", "[ -e stopped.states ]", "STOP",
                                     "generate beam.toml --mpi --patience 5 -o stopped.states" + finer);
  INFO(stopped.err);
  CHECK(ended_by_itself(stopped));
  CHECK(code_of_rank_0(shop) == "0\n");
  CHECK_THAT(stopped.err, Contains("1 of 3 ranks hang or are gone"));
  CHECK(states_of(shop, "stopped.states") == expected);
  const auto killed = ranks_but_one(shop, "--enable-recovery -n 2", "[ -e killed.states ]", "KILL",
                                    "generate beam.toml --mpi --patience 5 -o killed.states" + finer);
  INFO(killed.err);
  CHECK(states_of(shop, "killed.states") == expected);
  // Without recovery, MPI ends all ranks as soon as one ends. The solved states are on disk, and a rerun resumes.
  const auto ended = ranks_but_one(shop, "-n 2", "[ -e ended.states ]", "KILL",
                                   "generate beam.toml --mpi -o ended.states" + finer);
  if (states_of(shop, "ended.states") != expected) CHECK(ended.code != 0);
  const auto resumed = ranks(shop, 2, "generate beam.toml --mpi -o ended.states" + finer);
  INFO(resumed.err);
  CHECK(resumed.code == 0);
  CHECK(states_of(shop, "ended.states") == expected);
}

TEST_CASE(
    "rank 0 of generate says how many states are kept before mpirun ends it, when another rank has died",
    SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  // Every rank is the program itself: a shell around rank 0 would take the signal of mpirun.
  shop.write("long.sh",
             "if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then\n"
             "  (exec >/dev/null 2>&1; while ! [ -e long.states ]; do sleep 0.01; done; sleep 0.3; kill "
             "-KILL $$) &\n"
             "fi\nexec '" +
                 executable() +
                 "' generate beam.toml --mpi -o long.states --set body.elements=2000 "
                 "--set state_space.spacing=0.0002\n");
  const auto ended = shop.shell(as_root + run + "-n 2 bash long.sh");
  INFO(ended.err);
  CHECK(ended.code != 0);
  CHECK(ended.code != 124);  // of timeout(1); mpirun returns 128 + 9 of the rank that was killed
  const std::size_t said = ended.err.find(" states are kept in long.states; rerun");
  REQUIRE(said != std::string::npos);
  const std::size_t from = ended.err.rfind(' ', said - 1) + 1;
  CHECK(ended.err.find("forefeel:") == ended.err.rfind("forefeel:"));
  CHECK(shop.json("info long.states")["states"].get<int>() >= std::stoi(ended.err.substr(from, said - from)));
}

TEST_CASE("a session whose worker rank is stopped ends in time, and says which rank did not answer",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  const auto stopped =
      ranks_but_one(shop, "-n 3", is_larger("run/session.inputs"), "STOP",
                    "session beam.toml --mpi --patience 5 --clock real --seconds 12 -o run --json --quiet");
  INFO(stopped.err);
  CHECK(ended_by_itself(stopped));
  REQUIRE(code_of_rank_0(shop) == "0\n");
  const json summary = stopped.json();
  // A late frame is skipped and counted; frames of the last ramp may come after the end.
  const int frames = summary["frames"].get<int>() + summary["loop"]["skipped"].get<int>();
  CHECK(frames >= 12000);
  CHECK(frames <= 12000 + summary["loop"]["ending_frames"].get<int>());
  CHECK_THAT(summary["notes"].dump(), Contains("rank 1 has not answered for 5 s; its work goes to others"));
  CHECK(summary["states"]["solved"] > 10);
  CHECK(summary["faults"]["workers_lost"] == 1);
  CHECK_THAT(summary["attention"].dump(), Contains("1 worker was lost"));
}

TEST_CASE("a session whose worker rank is killed goes on with the other, where MPI allows it",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  const auto killed =
      ranks_but_one(shop, "--enable-recovery -n 3", "[ -e run/session.states ]", "KILL",
                    "session beam.toml --mpi --patience 5 --clock real --seconds 12 -o run --json --quiet");
  INFO(killed.err);
  CHECK(ended_by_itself(killed));
  REQUIRE(code_of_rank_0(shop) == "0\n");
  const json summary = json::parse(shop.read("run/summary.json"));
  CHECK(summary["frames"].get<int>() + summary["loop"]["skipped"].get<int>() >= 12000);
  CHECK(summary["faults"]["workers_lost"] == 1);
  CHECK(summary["interrupted"] == false);
}

TEST_CASE("generate anywhere by two ranks gives the states of threads, also in rounds",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  shop.write("any.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\nsite_spacing = 0.02\n"
             "[state_space]\ndepth = 0.006\n");
  for (const std::string& error : {std::string(), std::string(" --error 0.02")}) {
    shop.shell("rm -f threads.states ranks.states");
    const auto alone = shop.forefeel("generate any.toml -o threads.states --json --quiet" + error);
    const auto both = ranks(shop, 2, "generate any.toml --mpi -o ranks.states --json --quiet" + error);
    INFO(error << both.err);
    REQUIRE(both.code == alone.code);
    CHECK(both.json()["ranks"]["solving"] == 2);
    CHECK(both.json()["solved"] == alone.json()["solved"]);
    CHECK(both.json()["rounds"] == alone.json()["rounds"]);
    CHECK(states_of(shop, "ranks.states") == states_of(shop, "threads.states"));
  }
}

TEST_CASE("a session that touches anywhere has its workers in other processes",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const Workshop shop;
  if (const std::string why = reason_to_skip(shop); !why.empty()) return skip(why);
  shop.write("any.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\nsite_spacing = 0.02\n"
             "[state_space]\ndepth = 0.01\ntolerance = 0.001\n");
  const std::string session = "session any.toml --mpi --seconds 3 --device path:palpation,depth=0.008 ";
  const Workshop::Outcome by_two = ranks(shop, 3, session + "--clock real -o run --json --quiet");
  INFO(by_two.err);
  REQUIRE(by_two.code == 0);
  const json summary = by_two.json();
  CHECK(summary["workers"] == 2);
  CHECK(summary["touch"]["jets"].get<int>() > 0);
  CHECK(summary["states"]["solved"].get<int>() > 3);
  CHECK(summary["error"]["p95"].get<double>() < 0.05);
  const Workshop::Outcome simulated = ranks(shop, 3, session + "--clock virtual -o no --quiet");
  CHECK(simulated.code != 0);
  CHECK_THAT(simulated.err, Contains("--clock real"));
}

TEST_CASE("a session with its workers in other processes",
          SLOW("starts Open MPI, which only run.sh all installs")) {
  const BeamShop shop;
  const Workshop::Outcome alone = started_alone(shop);
  CHECK(alone.code == 2);
  CHECK(alone.error_lines() == 1);
  if (alone.err.find("no MPI") != std::string::npos) return skip("this build has no MPI");
  if (!has_command("mpirun")) return skip("mpirun is not installed");
  CHECK_THAT(alone.err, Contains("one rank"));

  const Workshop::Outcome solved_by_two =
      ranks(shop, 3, "session beam.toml --mpi --clock real --seconds 5 -o run --json --quiet");
  INFO(solved_by_two.err);
  REQUIRE(solved_by_two.code == 0);
  const json summary = solved_by_two.json();
  CHECK(summary["workers"] == 2);
  CHECK(summary["states"]["solved"] > 10);
  CHECK(summary["error"]["within_jnd"] > 0.5);

  // The states solved by the ranks, against the tight solve of one process.
  const auto solved = shop.shell(
      "awk -F, 'NR > 1 && NR < 12 {print $1\",\"$2\",\"$3}' run/states.csv | (echo x,y,z; cat) > points.csv");
  REQUIRE(solved.code == 0);
  const json tight = shop.json("solve beam.toml --points points.csv");
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

  CHECK_THAT(ranks(shop, 3, "session beam.toml --mpi --clock virtual -o other").err,
             Contains("no use under the virtual clock"));
  CHECK_THAT(ranks(shop, 2, "session nothing.toml --mpi -o other").err, Contains("no such file"));
  CHECK_THAT(ranks(shop, 3, "session beam.toml --mpi --clock real --workers 7 -o other").err,
             Contains("2 other ranks"));
  CHECK(!shop.has("other"));
}
