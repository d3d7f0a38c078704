// Unusual input and output: a full disk behind stdout, names that are not UTF-8, endless input, links, folders of other
// users, signals before the work begins.

#include "geometry/common/scanner.hpp"
#include "tests/support/executable.hpp"

namespace {

const char* const states_csv =
    "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,0,0\n0,0.01,0,0,-1,0\n0,0,0.01,0,0,-1\n";

}  // namespace

TEST_CASE("a full disk behind stdout is an error of every command", "[streams]") {
  const Workshop shop;
  shop.write("s.csv", states_csv);
  shop.write("q.csv", "x,y,z\n0.001,0,0\n");
  shop.write("beam.toml", beam_scene());
  for (const char* arguments :
       {"--help", "--version", "info s.csv", "info s.csv --json", "evaluate s.csv --points q.csv",
        "evaluate s.csv --points q.csv --json", "classify s.csv --spacing 0.01 --json",
        "import s.csv -o s.states --spacing 0.01", "export s.csv -o t.csv",
        "mesh --phantom slab --elements 150 -o a.msh", "solve beam.toml --at=0,0,0.001"}) {
    const auto outcome = shop.shell("'" + executable() + "' " + arguments + " > /dev/full");
    INFO(arguments << "\n" << outcome.err);
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Contains("stdout: cannot be written"));
  }
  const auto bad = shop.shell("'" + executable() + "' info absent > /dev/full");
  CHECK(bad.code == 2);
}

TEST_CASE("a path that is not UTF-8 is written into JSON with replacement characters", "[streams]") {
  const Workshop shop;
  shop.write("s\xff\xfe.csv", states_csv);
  shop.write("beam\xff.toml", beam_scene());
  if (!shop.has("s\xff\xfe.csv")) return skip("this file system has no such names");
  for (const char* arguments :
       {"info s\xff\xfe.csv --json", "import s\xff\xfe.csv -o \xff.states --spacing 0.01 --json",
        "export s\xff\xfe.csv -o \xff.csv --json", "info \xff.states --json",
        "solve beam\xff.toml --at=0,0,0.001 --json -o \xff-solved.csv",
        "generate beam\xff.toml -o beam\xff.states --json --set state_space.spacing=0.008",
        "session beam\xff.toml -o run\xff --clock virtual --seconds 0.05 --json"}) {
    const auto outcome = shop.run(arguments);
    CHECK(outcome.json().is_object());
  }
}

TEST_CASE("pages and pictures of a scene whose path is not UTF-8 are UTF-8", "[streams]") {
  const Workshop shop;
  shop.write("beam\xff.toml", beam_scene());
  if (!shop.has("beam\xff.toml")) return skip("this file system has no such names");
  for (const char* file : {"show.html", "show.vtu"}) {
    shop.run(std::string("show beam\xff.toml -o ") + file);
    CHECK(shop.shell(std::string("iconv -f UTF-8 -t UTF-8 ") + file + " | cmp - " + file).code == 0);
  }
  shop.run("session beam\xff.toml -o run --clock virtual --seconds 0.05");
  CHECK(shop.shell("iconv -f UTF-8 -t UTF-8 run/report.html | cmp - run/report.html").code == 0);
}

TEST_CASE("an output that is a pipe with a name, or a device in place of a state file, is refused",
          "[streams]") {
  const Workshop shop;
  shop.write("s.csv", states_csv);
  shop.write("beam.toml", beam_scene());
  REQUIRE(shop.shell("mkfifo pipe pipe.csv pipe.msh pipe.html").code == 0);
  for (const char* arguments :
       {"solve beam.toml --at=0,0,0.001 -o pipe", "export s.csv -o pipe.csv", "generate beam.toml -o pipe",
        "import s.csv -o pipe --spacing 0.01", "mesh --phantom slab --elements 150 -o pipe.msh",
        "show beam.toml -o pipe.html"}) {
    check_refused(shop, arguments, {"is a named pipe or socket, expected"});
  }
  for (const char* device : {"/dev/null", "/dev/full"})
    check_refused(shop, std::string("generate beam.toml -o ") + device, {device, "is no file"});
  // Devices, and pipes that the shell opened, are written.
  shop.run("export s.csv -o table.csv");
  shop.run("solve beam.toml --at=0,0,0.001 -o /dev/null");
  const auto piped =
      shop.shell("'" + executable() + "' solve beam.toml --at=0,0,0.001 --quiet -o /dev/stdout | head -c 5");
  CHECK(piped.out == "x,y,z");
}

TEST_CASE("an error quotes the beginning of a flood, not all of it", "[streams]") {
  const Workshop shop;
  const std::string flood(100'000, 'x');
  shop.write("flood.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0," + flood + "\n");
  shop.write("flood.toml", "[body]\nphantom = \"" + flood + "\"\n");
  shop.write("flood.obj", "v 0 0 " + flood + "\n");
  for (const std::string& arguments :
       {std::string("info flood.csv"), std::string("solve flood.toml --at=0,0,0"),
        std::string("info flood.obj"), "solve beam.toml --at=" + flood, flood, "info --" + flood,
        "session beam.toml --set " + flood + "=1 -o run", "info " + flood}) {
    const auto outcome = shop.forefeel(arguments);
    INFO(arguments.substr(0, 60) << "\n" << outcome.err.substr(0, 3000));
    CHECK(outcome.code == 2);
    CHECK(outcome.error_lines() == 1);
    CHECK(outcome.err.size() < 1600);
  }
}

TEST_CASE("-o keeps a symbolic link and a mode", "[streams]") {
  const Workshop shop;
  shop.write("s.csv", states_csv);
  shop.write("secret.csv", "mine\n");
  REQUIRE(shop.shell("chmod 600 secret.csv && ln -s secret.csv link.csv").code == 0);
  shop.run("export s.csv -o link.csv");
  CHECK(shop.shell("test -L link.csv && stat -c %a secret.csv && head -c 5 secret.csv").out == "600\nx,y,z");
}

TEST_CASE("a picture that is cut leaves nothing behind, and the target of a link is drawn", "[streams]") {
  if (!has_command("gnuplot")) return skip("gnuplot is not installed");
  const Workshop shop;
  shop.write("s.csv", states_csv);
  shop.run("classify s.csv --spacing 0.01 -o c.png --quiet");
  CHECK(shop.shell("head -c 4 c.png | tail -c 3").out == "PNG");
  // A leftover of a process that is gone is removed with the next picture.
  const int gone = std::stoi(shop.shell("sh -c 'echo $$'").out);
  const fs::path left = fs::temp_directory_path() / ("forefeel-tmp-" + std::to_string(gone) + "-abcdef");
  fs::create_directories(left);
  shop.run("classify s.csv --spacing 0.01 -o c.png --quiet");
  CHECK_FALSE(fs::exists(left));
  CHECK(shop.files() == "c.png\ns.csv\n");
}

TEST_CASE("folders with files of somebody else are refused, and those files stay", "[streams]") {
  const BeamShop shop;
  shop.write("study.toml", "scene = \"beam.toml\"\nseeds = [1]\n[vary]\npolicy = [\"fifo\"]\n");
  for (const char* file : {"states.csv", "report.html", "summary.json"}) {
    shop.write(std::string("run/") + file, "mine");
    check_refused(shop, "session beam.toml -o run --clock virtual --seconds 0.05",
                  {"run/" + std::string(file), "not made by forefeel"});
    fs::remove(shop.path() / "run" / file);
  }
  for (const char* file : {"cells.csv", "report.html"}) {
    shop.write(std::string("out/") + file, "mine");
    check_refused(shop, "study study.toml -o out", {"out/" + std::string(file), "not made by forefeel"});
    fs::remove(shop.path() / "out" / file);
  }
  shop.write("run/notes.txt", "mine");
  shop.run("session beam.toml -o run --clock virtual --seconds 0.05 --quiet");
  shop.run("session beam.toml -o run --clock virtual --seconds 0.05 --quiet");
}

TEST_CASE("a cut frames.csv is not replayed", "[streams]") {
  const BeamShop shop;
  shop.run("session beam.toml -o run --clock virtual --seconds 0.05 --quiet");
  // The file is cut within z of the last row, so that the rest could also be a shorter number.
  REQUIRE(shop.shell("n=$(head -n -1 run/frames.csv | wc -c); cp run/frames.csv whole.csv; "
                     "head -c $((n + 12)) whole.csv > run/frames.csv")
              .code == 0);
  check_refused(shop, "session beam.toml -o again --replay run --clock virtual --seconds 0.05",
                {"run/frames.csv:51", "cut short"});
  REQUIRE(shop.shell("cp whole.csv run/frames.csv; truncate -s -3 run/dispatch.csv").code == 0);
  check_refused(shop, "session beam.toml -o again --replay run --clock virtual --seconds 0.05",
                {"run/dispatch.csv", "cut short"});
}

TEST_CASE("spacings and moduli that no body has are refused", "[streams]") {
  const BeamShop shop;
  for (const char* set :
       {"state_space.spacing=1e300", "state_space.spacing=20", "material.young=1e-300", "material.young=1e-4",
        "material.young=1e16", "'state_space.box=[[-1e9,-1e9,-1e9],[1e9,1e9,1e9]]'"})
    check_refused(shop, std::string("solve beam.toml --at=0,0,0.001 --set ") + set, {"expected"});
}

TEST_CASE("a lattice that does not fit into the memory is refused before anything is solved", "[streams]") {
  if (sanitized) return skip("a sanitizer needs the whole address space");
  const BeamShop shop;
  const auto outcome =
      shop.shell("ulimit -v 4000000; '" + executable() +
                 "' generate beam.toml -o g.states --threads 1 --set state_space.spacing=0.0001 "
                 "--set 'state_space.box=[[-0.012,-0.012,-0.012],[0.012,0.012,0.012]]'");
  INFO(outcome.err);
  CHECK(outcome.code == 2);
  CHECK(outcome.error_lines() == 1);
  CHECK_THAT(outcome.err, Contains("state_space.box: a lattice of 0.0001 m in it would take",
                                   "GB of memory, but", "are left"));
  CHECK_FALSE(fs::exists(shop.path() / "g.states"));
}

TEST_CASE("more threads than the limits of the process allow are refused in one line", "[streams]") {
  if (sanitized) return skip("a sanitizer needs the whole address space");
  const BeamShop shop;
  for (const char* arguments : {"solve beam.toml --at=0,0,0.001 --threads 1000",
                                "session beam.toml -o run --clock real --seconds 0.2 --workers 1000"}) {
    const auto outcome = shop.shell("ulimit -v 3000000; '" + executable() + "' " + arguments);
    INFO(arguments << "\n" << outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.error_lines() == 1);
    CHECK_THAT(outcome.err, Contains("is 1000", "expected at most"));
  }
  CHECK_FALSE(fs::exists(shop.path() / "run"));
  CHECK(shop.shell("ulimit -v 3000000; '" + executable() + "' solve beam.toml --at=0,0,0.001 --threads 2")
            .code == 0);
}

TEST_CASE("a signal ends a command that still plans", "[streams]") {
  const BeamShop shop;
  const auto outcome = shop.shell(
      "'" + executable() +
      "' generate beam.toml -o g.states --json --set material.law=linear --set state_space.spacing=0.00015 "
      "--set 'state_space.box=[[-0.012,-0.012,-0.012],[0.012,0.012,0.012]]' & p=$!; " +
      wait_until(takes_signals) + "sleep 1; kill -TERM $p; wait $p");
  INFO(outcome.err);
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("interrupted before"));
  CHECK(outcome.json()["interrupted"] == true);
}

TEST_CASE("a state file is not replaced by a table, nor a stranger's file set aside as states", "[streams]") {
  const BeamShop shop;
  shop.write("s.csv", states_csv);
  shop.run("import s.csv -o mine.states --spacing 0.01");
  const std::string before = read_text_file(shop.path() / "mine.states");
  for (const char* arguments :
       {"solve beam.toml --at=0,0,0 -o mine.states", "evaluate s.csv --points s.csv -o mine.states",
        "mesh --phantom slab --elements 150 -o mine.states"}) {
    check_refused(shop, arguments, {"mine.states"});
    CHECK(read_text_file(shop.path() / "mine.states") == before);
  }
  fs::create_directory(shop.path() / "own");
  shop.write("own/session.states", "mine");
  const std::string session = "session beam.toml -o own --clock virtual --seconds 0.05";
  check_refused(shop.forefeel(session), session, {"own/session.states", "expected another folder"});
  CHECK(read_text_file(shop.path() / "own/session.states") == "mine");
}

TEST_CASE("a disk that fills during generate: what is kept is counted, and a rerun resumes",
          "[streams]" SLOW("waits for a disk that fills")) {
  const BeamShop shop;
  struct Way {
    const char* how;
    int blocks;  // limit of a file, and so of the log [512 bytes]
  };
  for (const auto& [how, blocks] : {Way{"--set state_space.spacing=0.0003", 3000},
                                    Way{"--error 1e-5 --set state_space.spacing=0.0002", 120}}) {
    INFO(how);
    const std::string generate = "'" + executable() + "' generate beam.toml -o g.states --json " + how;
    const auto full = shop.shell("rm -f g.states; ulimit -f " + std::to_string(blocks) + "; " + generate);
    INFO(full.err);
    CHECK(full.code == 1);
    const auto kept = shop.json("info g.states")["states"].get<int>();
    CHECK(kept > 0);
    CHECK_THAT(full.err,
               Contains("g.states: cannot be", "; " + std::to_string(kept) + " states are kept in it; free"));
    CHECK(full.json()["states"] == kept);
    CHECK(full.json()["interrupted"] == true);
    const std::string goes_on = "[ $('" + executable() +
                                "' info g.states --json | sed -n '3s/[^0-9]//gp') -gt " +
                                std::to_string(kept) + " ]";
    const auto again = shop.shell(generate + " & p=$!; " + wait_until(goes_on) + "kill -INT $p; wait $p");
    CHECK(again.json()["resumed"] == kept);
  }
}

TEST_CASE("a state file that is moved while it is written is said to be incomplete", "[streams]") {
  const BeamShop shop;
  const auto outcome = shop.shell(
      "'" + executable() + "' generate beam.toml -o m.states --set state_space.spacing=0.0004 & p=$!; " +
      wait_until("[ -s m.states-wal ]") + "mv m.states n.states; wait $p");
  INFO(outcome.err);
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("m.states: was moved or removed"));
}

TEST_CASE("keys of TOML with tens of thousands of parts and names of 100 kB get one short line",
          "[streams]") {
  const Workshop shop;
  std::string key = "a";
  for (int part = 1; part < 60'000; ++part) key += ".a";
  shop.write("key.toml", "# ....\n" + key + " = 1\n");
  shop.write("header.toml", "[" + key + "]\n");
  const std::string flood(100'000, 'x');
  for (const std::string& arguments :
       {std::string("solve key.toml --at=0,0,0"), std::string("solve header.toml --at=0,0,0"),
        std::string("study key.toml -o run"), std::string("study header.toml -o run"),
        "session " + flood + ".toml -o run", "solve " + flood + ".toml --at=0,0,0",
        "study " + flood + ".toml -o run"}) {
    const auto outcome = shop.forefeel(arguments);
    INFO(arguments.substr(0, 40) << "\n" << outcome.err.substr(0, 500));
    CHECK(outcome.code == 2);
    CHECK(outcome.err.size() < 1000);
    CHECK_THAT(outcome.err, Contains("expected"));
  }
}
