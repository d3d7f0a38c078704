#include "apps/scene/phantom_cache.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/meshing/phantom.hpp"
#include "tests/support/executable.hpp"

namespace {

Scene load(const Workshop& shop, const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scene(shop.write("scene.toml", text), overrides);
}

}  // namespace

TEST_CASE("a scene holds what its file says", "[scene]") {
  const Workshop shop;
  const Scene scene = load(shop, beam_scene(R"(displacements = true
[model]
kernel = "cubic"
data = "force"
neighbours = 60
select = "nearest"
[session]
device = "path:circle"
clock = "virtual"
seconds = 3
workers = 5
policy = "nearest"
switch = "paper"
cost = "lognormal:0.1,0.5"
latency = 0.002
update_travel = 0.5
preempt = false
seed = 9
[session.jnd]
share = 0.1
floor = 0.02
[session.limits]
force = 5
slew = 100
ramp = 0
stale = 1
)"));
  CHECK(scene.kept.displacements);
  CHECK(scene.model.kernel == Kernel::cubic);
  CHECK(scene.model.neighbours == 60);
  CHECK(scene.session.model.fit.select == Select::nearest);
  CHECK(scene.session.clock.kind == Clock::virtual_time);
  CHECK(scene.session.clock.seconds == 3);
  CHECK(scene.session.workers.count == 5);
  CHECK(scene.session.planning.policy.name == "nearest");
  CHECK(scene.session.switching.rule == SwitchRule::paper);
  CHECK(scene.session.switching.jnd_share == 0.1);
  CHECK(to_text(cost_of(scene)) == "lognormal:0.1,0.5");
  CHECK_FALSE(scene.session.planning.preempt);
  CHECK(scene.session.seed == 9);
  CHECK(scene.session.safety.force_limit == 5);
  CHECK(scene.session.safety.ramp_seconds == 0);
  CHECK(scene.body->mesh.tets.size() >= 228);
  CHECK(scene.body->mesh.tets.size() <= 252);
  CHECK(scene.space.box.low == Vec3::Constant(-0.004));
}

TEST_CASE("a session in code and a scene without [model] have the same model", "[scene]") {
  const Workshop shop;
  const ModelOptions scene = load_scene(shop.write("plain.toml", beam_scene())).session.model.fit;
  const ModelOptions code = SessionOptions().model.fit;
  CHECK(scene.kernel == code.kernel);
  CHECK(scene.data == code.data);
  CHECK(scene.neighbours == code.neighbours);
  CHECK(scene.select == code.select);
  CHECK(scene.ridge == code.ridge);
}

TEST_CASE("meshes of phantoms are kept: the same bits, and damaged ones are made anew", "[scene]") {
  const Workshop shop;
  const TetMesh made = phantom("beam", 240);
  const std::string bytes = mesh_bytes(made);
  const auto same = [&](const std::optional<TetMesh>& mesh) {
    return mesh && mesh->nodes == made.nodes && mesh->tets == made.tets && mesh->groups == made.groups;
  };
  CHECK(made.groups.size() == 2);
  CHECK(same(mesh_of_bytes(bytes)));
  for (const std::size_t cut :
       {std::size_t{0}, std::size_t{5}, std::size_t{40}, bytes.size() / 2, bytes.size() - 1})
    CHECK_FALSE(mesh_of_bytes(std::string_view(bytes).substr(0, cut)));
  std::string changed = bytes;
  changed[bytes.size() / 3] ^= 1;
  CHECK_FALSE(mesh_of_bytes(changed));
  const TetMesh slab = phantom("slab");
  REQUIRE(slab.element_groups.contains("lump"));
  CHECK(mesh_of_bytes(mesh_bytes(slab)).value().element_groups == slab.element_groups);

  shop.write("beam.toml", beam_scene());
  const auto force = [&] {
    return shop.json("solve beam.toml --at=0,0,-0.003 --quiet")["states"][0]["force"];
  };
  const auto first = force();
  const std::string kept = shop.shell("cat ../cache/forefeel/*.mesh").out;
  CHECK(same(mesh_of_bytes(kept)));
  CHECK(force() == first);
  REQUIRE(shop.shell("for f in ../cache/forefeel/*.mesh; do printf damaged > $f; done").code == 0);
  CHECK(force() == first);
  CHECK(shop.shell("cat ../cache/forefeel/*.mesh").out == kept);
}

TEST_CASE("overrides take the place of what the file says", "[scene]") {
  const Workshop shop;
  const Scene scene =
      load(shop, beam_scene("[clamp]\ngroup = \"clamp\"\n"),
           {"material.poisson=0.4", "session.policy=nearest", "clamp.below.axis=z", "clamp.below.share=0.1",
            "contact.node=0", "clamp.below.axis=x", "contact.nearest=[0.1, 0.01, 0.01]", "body.length=0.2"});
  CHECK(scene.body->material.poisson == 0.4);
  CHECK(scene.session.planning.policy.name == "nearest");
  CHECK(scene.body->contact.size() == 1);
  CHECK(longest_side(scene.body->mesh) == Approx(0.2));
  for (const NodeIndex node : scene.body->clamp)
    CHECK(scene.body->mesh.nodes[static_cast<std::size_t>(node)].x() <= 0.02 + 1e-12);
}

TEST_CASE("a contact's radius takes the surface around it", "[scene]") {
  const Workshop shop;
  const std::string contact = "[contact]\nnearest = [0.1, 0.01, 0.01]\n";
  const Scene one = load(shop, beam_scene(contact)),
              patch = load(shop, beam_scene(contact + "radius = 0.012\n"));
  CHECK(one.body->contact.size() == 1);
  CHECK(patch.body->contact.size() > 1);
  const Vec3 centre = one.body->mesh.nodes[static_cast<std::size_t>(one.body->contact.front())];
  const std::vector<NodeIndex> surface = surface_nodes(patch.body->mesh);
  std::vector<NodeIndex> near;
  for (const NodeIndex node : surface)
    if ((patch.body->mesh.nodes[static_cast<std::size_t>(node)] - centre).norm() <= 0.012)
      near.push_back(node);
  CHECK(patch.body->contact == near);
  CHECK((patch.inward - -Vec3::UnitX()).norm() < 1e-9);  // the end face looks along +x
}

TEST_CASE("identity tells which part of a body differs", "[scene]") {
  const Workshop shop;
  const BodyIdentity base = load(shop, beam_scene()).identity;
  CHECK(base == load(shop, beam_scene()).identity);
  for (const auto& [key, override] :
       std::map<std::string, std::string>{{"material", "material.young=5001"},
                                          {"mesh", "body.length=0.11"},
                                          {"clamp", "clamp.nodes=[0]"},
                                          {"contact", "contact.nearest=[0.1,0,0]"}}) {
    const BodyIdentity other = load(shop, beam_scene(), {override}).identity;
    for (const auto& [name, value] : base) {
      INFO("override " << override << ", key " << name);
      CHECK((other.at(name) == value) == (name != key));
    }
  }
}

TEST_CASE("a scene's hash sees values, not comments or order", "[scene]") {
  const Workshop shop;
  const std::string text = beam_scene(), hash = load(shop, text).source.hash;
  CHECK(load(shop, "# a remark\n" + text).source.hash == hash);
  CHECK(load(shop, text, {"material.poisson=0.3"}).source.hash == hash);
  CHECK(load(shop, text, {"material.poisson=0.31"}).source.hash != hash);
  CHECK(load(shop, text, {"session.seed=1"}).source.hash != hash);
}

TEST_CASE("errors name file, line, key and what was expected", "[scene]") {
  const Workshop shop;
  const auto message = [&](const std::string& text,
                           const std::vector<std::string>& overrides = {}) -> std::string {
    return error_of([&] { load(shop, text, overrides); });
  };
  CHECK_THAT(message("[body]\nphantom = \"beam\"\n[session]\npolicy = \"neerest\"\n"),
             Contains("scene.toml:4: session.policy", "nearest: 'nearest'"));
  CHECK_THAT(message("[body]\nphantom = \"beam\"\n[session.limits]\nforce = -1\n"),
             Contains("scene.toml:4: session.limits.force", "above 0"));
  CHECK_THAT(message(beam_scene(), {"session.limts.force=1"}),
             Contains("--set session.limts", "did you mean 'session.limits'"));
  CHECK_THAT(message(beam_scene(), {"material.poisson=[1]"}),
             Contains("--set material.poisson: is a list of 1"));
  CHECK_THAT(message(beam_scene("[model]\nkernel = \"linear\"\ndata = \"force+stiffness\"\n")),
             Contains("model.data"));
  CHECK_THAT(message(beam_scene("[model]\nselect = \"label\"\n[session]\nselect = \"label\"\n")),
             Contains("only one of"));
  CHECK_THAT(message(beam_scene("[session]\narrivals = \"absent.csv\"\n")),
             Contains("session.arrivals", "absent.csv"));
  CHECK_THAT(message("[body]\nelements = 5\n"), Contains("body", "exactly one of mesh, phantom"));
  CHECK_THAT(message("body = 3\n"), Contains("expected a table"));
  CHECK_THAT(message(beam_scene(), {"material.young=inf"}), Contains("above 0"));
  for (const char* place : {"[1e200, 0, 0]", "[-100, 0, 0]", "[1e308, -1e308, 1e308]"}) {  // -100: in mm
    CHECK_THAT(
        message(beam_scene("[contact]\nnearest = " + std::string(place) + "\n")),
        Contains("scene.toml:12: contact.nearest: has x = ", "far from the body, expected about 0 to 0.1"));
  }
  CHECK(message(beam_scene("[contact]\nnearest = [0.1, 0, 1]\n")).empty());
}
