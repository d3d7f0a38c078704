// Bad input: one clear line on stderr, exit code 2, no file written.

#include "tests/support/executable.hpp"

namespace {

// A tetrahedron pair that shares a face, as .msh 2.2; `tets` are the rows of elements.
std::string msh(const std::string& tets, int count) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 0.1 0 0\n3 0 0.1 0\n4 0 0 0.1\n5 0.1 "
         "0.1 0.1\n6 0.3 0.3 0.3\n$EndNodes\n"
         "$Elements\n" +
         std::to_string(count) + "\n" + tets + "$EndElements\n";
}

const std::string good_tets = "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 2 5 3 4\n";

std::string mesh_scene(const std::string& mesh = "body.msh", const std::string& clamp = "nodes = [0, 1, 2]",
                       const std::string& contact = "node = 4") {
  return "[body]\nmesh = \"" + mesh +
         "\"\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson = 0.3\n[clamp]\n" + clamp +
         "\n[contact]\n" + contact +
         "\n[state_space]\nspacing = 0.006\nbox = [[-0.006, -0.006, -0.006], [0.006, 0.006, 0.006]]\n";
}

}  // namespace

TEST_CASE("usage errors are one line", "[command-line]") {
  const BeamShop shop;
  check_refused(shop, "-v", {"unknown option '-v', expected a command or --version, see forefeel --help"});
  check_refused(shop, "sesion beam.toml", {"'sesion'", "did you mean 'session'"});
  check_refused(shop, "nosuch beam.toml", {"command 'nosuch': unknown, expected one of mesh, solve"});
  check_refused(shop, "--jsn", {"--jsn"});
  check_refused(shop, "solve beam.toml --att=0,0,0", {"--att", "did you mean '--at'"});
  check_refused(shop, "solve", {"SCENE"});
  check_refused(
      shop, "solve beam.toml --at=0,0,-10",
      {"the position (0, 0, -10) m is 10 m from rest, expected at most 0.2 m, twice the body's length (are "
       "the values in metres?)"});
  check_refused(shop, "solve beam.toml --at=0,0,1e300",
                {"1e+300 m from rest", "twice the body's length", "metres?"});
  check_refused(shop, "solve beam.toml --at=0,0,0 --threads -2", {"--threads"});
  check_refused(shop, "solve beam.toml --at=0,0,0 --seed none", {"--seed"});
  check_refused(shop, "solve beam.toml --at=0,0,0 --seed -1", {"--seed", "at least 0"});
  check_refused(shop, "evaluate s.csv --points q.csv --neighbours 0", {"--neighbours", "above 0"});
  check_refused(shop, "classify s.csv --safe-angle nan", {"--safe-angle", "above 0"});
}

TEST_CASE("an instruction set that is none is refused at the start", "[command-line]") {
  const Workshop shop;
  const std::string program = "'" + executable() + "' ";
  for (const std::string wrong : {"bogus", "AVX2", "avx2 "}) {
    const Workshop::Outcome outcome = shop.shell("FOREFEEL_ISA='" + wrong + "' " + program + "cache");
    INFO(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.error_lines() == 1);
    for (const std::string& word :
         {std::string("FOREFEEL_ISA"), "'" + wrong + "'", std::string("portable, avx2 or avx512")})
      CHECK_THAT(outcome.err, Contains(word));
  }
  for (const std::string right : {"", "portable", "avx2", "avx512"})
    CHECK(shop.shell("FOREFEEL_ISA='" + right + "' " + program + "--version").code == 0);
}

TEST_CASE("--set is refused where a command reads no scene, and its help says so", "[command-line]") {
  const Workshop shop;
  for (const std::string command :
       {"import s.csv -o s.states", "export s.states -o s.csv", "reproduce", "cache"}) {
    const std::string name = command.substr(0, command.find(' '));
    check_refused(shop, command + " --set nosuch=1",
                  {"--set: is about keys of a scene, but " + name + " reads none, expected no --set"});
    CHECK_THAT(shop.forefeel(name + " --help").out, Contains("refused here"));
  }
}

TEST_CASE("errors of the command line name the option, what was given and what was expected",
          "[command-line]") {
  const Workshop shop;
  const std::pair<std::string, std::string> wrong[] = {
      {"session b.toml -o r --seed 1.5",
       "--seed: is '1.5', expected a whole number of at least 0, below 2^64"},
      {"session b.toml -o r --seed", "--seed: has no value, expected --seed N"},
      {"session b.toml -o r --workers two", "--workers: is 'two', expected a whole number"},
      {"session b.toml -o r --seconds long", "--seconds: is 'long', expected a number"},
      {"session b.toml -o r --threads 99999", "--threads: is 99999, expected 0 to 4096"},
      {"session b.toml -o r --clock real --clock virtual", "--clock: is given 2 times, expected once"},
      {"session b.toml -o r --states s --extend --foreign",
       "--extend: is given with --foreign, expected one of the two"},
      {"session b.toml", "--output: is missing, see forefeel session --help"},
      {"session -o r", "session: SCENE is missing, see forefeel session --help"},
      {"classify s --diff a", "--diff: has 1 of its values, expected 2"},
      {"session b.toml -o r --json=maybe", "--json: is 'maybe', expected no value"},
      {"evaluate s --points q --kernel x", "--kernel: is 'x', expected one of linear, cubic, quintic"}};
  for (const auto& [command, message] : wrong) {
    INFO(command);
    check_refused(shop, command, {"forefeel: " + message + "\n"});
  }
}

TEST_CASE("help and version are not errors", "[command-line]") {
  const Workshop shop;
  const auto version = shop.run("--version");
  for (const char* library : {"forefeel ", "CGAL", "TetGen", "Eigen", "SQLite"})
    CHECK_THAT(version.out, Contains(library));
  for (const std::string command : {"", "mesh ", "solve ", "generate ", "import ", "export ", "info ",
                                    "show ", "classify ", "evaluate ", "session ", "reproduce "}) {
    const auto help = shop.run(command + "--help");
    CHECK(help.err.empty());
    if (!command.empty())
      for (const char* option : {"--json", "--quiet", "--threads", "--seed", "--set"})
        CHECK_THAT(help.out, Contains(option));
  }
}

TEST_CASE("without a word the commands are listed in groups, each with an example", "[command-line]") {
  const Workshop shop;
  const auto bare = shop.run("");
  CHECK(bare.out == shop.run("--help").out);
  CHECK(shop.run("version").out == shop.run("--version").out);
  std::size_t examples = 0;
  for (std::size_t at = 0; (at = bare.out.find("\n  Example: forefeel ", at)) != std::string::npos; ++at)
    ++examples;
  CHECK(examples == 4);
  CHECK(bare.out.find("  session ") > bare.out.find("  classify "));
  CHECK_THAT(bare.out, Contains("\nStates, ") && Contains("\n  Example: forefeel session "));
}

TEST_CASE("positions must be three finite numbers", "[command-line]") {
  const BeamShop shop;
  for (const char* at :
       {"nan,0,0", "0,inf,0", "0,0", "0,0,0,0", "0,,0", "a,b,c", "'0;0;0'", "1e999,0,0", "''"})
    check_refused(shop, std::string("solve beam.toml --at=") + at, {"--at"});
  const auto negative = shop.run("solve beam.toml --json --at=-0.001,0,-.002");
  CHECK(negative.json()["states"][0]["at"] == json({-0.001, 0.0, -0.002}));
  shop.write("short.csv", "x,y,z\n0,0,0\n0.001,0\n");
  check_refused(shop, "solve beam.toml --points short.csv", {"short.csv:3"});
  shop.write("nan.csv", "x,y,z\n0,0,0\n0.001,nan,0\n");
  check_refused(shop, "solve beam.toml --points nan.csv", {"nan.csv:3"});
  check_refused(shop, "solve beam.toml --points absent.csv", {"absent.csv"});
}

TEST_CASE("scenes that cannot be read", "[command-line]") {
  const Workshop shop;
  shop.write("my organ.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  check_refused(shop, "session 'my organ.obj' -o run",
                {"my organ.obj: is a shape", "forefeel mesh 'my organ.obj' -o 'my organ.msh'", "body.mesh"});
  shop.write("body.msh", msh(good_tets, 2));
  check_refused(shop, "solve body.msh --at=0,0,0", {"forefeel mesh body.msh -o body-mesh.msh"});
  check_refused(shop, "solve absent.toml --at=0,0,0", {"absent.toml"});
  shop.write("cut.toml", "[body]\nphantom = \"bea");
  check_refused(shop, "solve cut.toml --at=0,0,0", {"cut.toml:2"});
  shop.write("missing.toml", mesh_scene("absent.msh"));
  check_refused(shop, "solve missing.toml --at=0,0,0", {"missing.toml:2", "absent.msh"});
  shop.write("beam.toml", beam_scene());
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"material.poison=0.3", "material.poisson"},
      {"material.poisson=0.5", "0.5"},
      {"material.poisson=soft", "soft"},
      {"material.young=-5", "-5"},
      {"material.young=0", "above 0"},
      {"material.young=nan", "nan"},
      {"material.law=neo-hook", "neo-hookean"},
      {"session.policy=coverag", "coverage"},
      {"session.seconds=-1", "-1"},
      {"session.workers=0", "from 1"},
      {"session.clock=imaginary", "virtual"},
      {"session.switch=rough", "smooth"},
      {"contact.node=100000", "out of range"},
      {"contact.nodes=[-1]", "-1"},
      {"contact.radius=-1", "-1"},
      {"clamp.nodes=[]", "not empty"},
      {"clamp.group=nowhere", "contact"},
      {"clamp.below={axis=\"w\",share=0.1}", "x, y, z"},
      {"clamp.below={axis=\"z\"}", "share"},
      {"state_space.spacing=0", "above 0"},
      {"state_space.spacing=automatic", "\"auto\""},
      {"state_space.tolerance=-1", "above 0"},
      {"state_space.box=[[0,0,0],[-1,1,1]]", "low corner"},
      {"state_space.spacing=1e-9", "positions"},
      {"model.kernel=quartic", "quintic"},
      {"model.neighbours=0", "from 1"},
      {"bodi.mesh=a", "did you mean 'body'"},
      {"body.phantom=lung", "liver"},
      {"body.length=-1", "above 0"},
      {"material", "key.path=value"},
      {"material.poisson.x=1", "not a table"}};
  for (const auto& [override, mention] : wrong)
    check_refused(shop, "solve beam.toml --at=0,0,0 --set '" + override + "'", {mention});
}

TEST_CASE("meshes that cannot be solved", "[command-line]") {
  const Workshop shop;
  shop.write("scene.toml", mesh_scene());
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& mentions) {
    shop.write("body.msh", text);
    check_refused(shop, "solve scene.toml --at=0,0,0", mentions);
  };
  refuse("", {"body.msh"});
  const std::string good = msh(good_tets, 2);
  refuse(good.substr(0, good.size() / 2), {"body.msh"});
  refuse(good.substr(0, good.find("$Elements") + 14), {"body.msh"});
  refuse(msh("1 2 2 0 1 1 2 3\n", 1), {"body.msh", "tetrahedra"});
  refuse(msh("1 4 2 0 1 1 2 3 4\n2 4 2 0 1 2 5 3 3\n", 2), {"body.msh"});
  refuse(msh("1 4 2 0 1 1 2 3 9\n", 1), {"body.msh"});
  shop.write("body.msh", good);
  shop.run("solve scene.toml --at=0,0,0");
  // All flipped, or one of them: they are turned, with a warning.
  for (const char* tets :
       {"1 4 2 0 1 2 1 3 4\n2 4 2 0 1 5 2 3 4\n", "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 5 2 3 4\n"}) {
    shop.write("body.msh", msh(tets, 2));
    const auto flipped = shop.run("solve scene.toml --at=0,0,0 --json");
    CHECK_THAT(flipped.err, Contains("warning"));
  }
}

TEST_CASE("node sets that cannot be solved", "[command-line]") {
  const Workshop shop;
  shop.write("body.msh", msh(good_tets, 2));
  const auto refuse = [&](const std::string& clamp, const std::string& contact, const std::string& mention) {
    shop.write("scene.toml", mesh_scene("body.msh", clamp, contact));
    check_refused(shop, "solve scene.toml --at=0,0,0", {mention});
  };
  refuse("nodes = [4]", "node = 4", "contact");
  refuse("nodes = []", "node = 4", "clamp");
  refuse("nodes = [0]", "node = 99", "out of range");
  refuse("nodes = [0]\ngroup = \"a\"", "node = 4", "exactly one of");
  refuse("", "node = 4", "exactly one of");
  refuse("nodes = [0]", "node = 4\nnearest = [0, 0, 0]", "exactly one of");
  refuse("nodes = [0]", "radius = 0.01", "exactly one of");
  refuse("group = \"bottom\"", "node = 4", "no node groups");
  // A second part that no clamp holds.
  shop.write("body.msh",
             "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 5 0 "
             "0\n6 6 0 0\n7 5 1 0\n8 5 0 1\n$EndNodes\n"
             "$Elements\n2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 5 6 7 8\n$EndElements\n");
  refuse("nodes = [0]", "node = 3", "clamp");
}

TEST_CASE("states, devices and outputs that cannot be used", "[command-line]") {
  const BeamShop shop;
  check_refused(shop, "session beam.toml --seconds -1 -o run", {"seconds"});
  check_refused(shop, "session beam.toml --policy wisest -o run", {"wisest"});
  check_refused(shop, "session beam.toml --seed 99999999999999999999 -o run",
                {"--seed", "99999999999999999999"});
  check_refused(shop, "session beam.toml --latency 1e300 -o run", {"latency", "86400"});
  check_refused(shop, "session beam.toml --latency 86401 -o run", {"latency", "86400"});
  check_refused(shop, "session beam.toml --latency -0.1 -o run", {"latency", "-0.1"});
  check_refused(shop, "session beam.toml --set session.latency=1e9 -o run", {"latency", "86400"});
  for (const std::string method : {"trilinear", "tricubic"})
    for (const std::string placement : {"adaptive", "path"})
      check_refused(shop,
                    "session beam.toml --set session.method=" + method +
                        " --set session.placement=" + placement + " -o run",
                    {"session.placement", "lattice", method});
  check_refused(shop, "session beam.toml --set session.visit_cell=1e-300 -o run", {"visit_cell", "1e-9 m"});
  check_refused(shop, "session beam.toml -o ''", {"--output", "empty"});
  check_refused(shop, "session beam.toml --device path:spiral -o run", {"spiral"});
  check_refused(shop, "session beam.toml --device trace:absent.csv -o run", {"absent.csv"});
  shop.write("nan.csv", "t,x,y,z\n0,0,0,0\n0.1,nan,0,0\n");
  check_refused(shop, "session beam.toml --device trace:nan.csv -o run", {"nan.csv:3"});
  shop.write("back.csv", "t,x,y,z\n0,0,0,0\n0.2,0,0,0\n0.1,0,0,0\n");
  check_refused(shop, "session beam.toml --device trace:back.csv -o run", {"back.csv:4"});
  shop.write("short.csv", "t,x,y,z\n0,0,0,0\n0.2,0,0\n");
  check_refused(shop, "session beam.toml --device trace:short.csv -o run", {"short.csv:3"});
  shop.write("mm.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-20\n");
  check_refused(shop, "session beam.toml --seconds 1 --device trace:mm.csv -o run",
                {"mm.csv", " m from rest, expected at most 0.2 m", "are the values in metres?"});
  shop.write("just.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-0.201\n");
  check_refused(shop, "session beam.toml --seconds 1.001 --device trace:just.csv -o run",
                {"0.201 m from rest, expected at most 0.2 m, twice the body's length\n"});
  shop.write("spiral.toml", beam_scene("[session]\ndevice = \"path:spiral\"\n"));
  check_refused(shop, "session spiral.toml -o run", {"spiral.toml", "session", "'spiral'"});
  check_refused(shop, "session beam.toml --clock wooden -o run", {"wooden"});
  check_refused(shop, "session beam.toml --workers 0 -o run", {"workers"});
  check_refused(shop, "session beam.toml --seconds 0.1 -o beam.toml/run", {"beam.toml/run"});
  check_refused(shop, "generate beam.toml -o nowhere/s.states", {"nowhere"});
  check_refused(shop, "solve beam.toml --at=0,0,0 -o nowhere/out.csv", {"nowhere"});
  shop.write("states.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.006,0,0,-1,0\n");
  check_refused(shop, "classify states.csv --spacing 0.006 --grid 0.006", {"states.csv:3"});
  check_refused(shop, "import states.csv -o s.states --spacing 0.006", {"states.csv:3"});
  shop.write("empty.states", "");
  check_refused(shop, "info absent.states", {"absent.states"});
}

TEST_CASE("a state file of another scene is refused with what differs", "[command-line]") {
  const BeamShop shop;
  shop.run("generate beam.toml -o beam.states --quiet");
  const std::string before = shop.files();
  check_refused(shop, "generate beam.toml -o beam.states --set material.young=6000", {"material"});
  CHECK(shop.files() == before);
  check_refused(shop, "session beam.toml --states beam.states --seconds 0.1 --set material.young=6000 -o run",
                {"material"});
}
