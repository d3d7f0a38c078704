#pragma once
// The content of `forefeel show` as plain data: a body, a box, states, labels, and the path of the hand. Positions are
// HIP positions [m]; x = 0 is the rest position of the contact. Without a contact (a mesh or surface alone), positions
// are those of the mesh.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// Number of the clamp, the contact and the rest in ShownBody::role.
enum class Role : std::uint8_t { free, clamp, contact };

struct ShownGroup {
  std::string name;
  std::vector<std::uint32_t> nodes;  // of the surface, rising
};

// Tetrahedra of one material, or a group of the mesh, that are not the whole body.
struct ShownRegion {
  std::string name, words;  // words: of its material; empty for a group of a mesh
  double volume = 0;        // [m^3]
};

// Where tetrahedra of one region touch those of another, or the rest of the body. Each triangle once.
struct ShownInterface {
  std::vector<Vec3> nodes;           // [m]
  std::vector<Triangle> triangles;   // outward from their region
  std::vector<std::uint8_t> region;  // #triangles: number of the region in ShownRegions::all, from 0
  bool empty() const { return triangles.empty(); }
};

struct ShownRegions {
  std::vector<ShownRegion> all;
  // 0 the rest, k: all[k - 1]; empty without regions
  std::vector<std::uint8_t> of_triangle, of_tet;  // #triangles of the body; #T of its mesh
  std::string rest_words;                         // material of the rest
  ShownInterface inside;
};

// springs: of a pad at one place. With contact.anywhere the body's stiffness at rest, or the estimated error of the
// force where the tip is pressed straight in, over the tolerance.
enum class PadShade : std::uint8_t { springs, stiffness, error };
std::string_view name(PadShade shade);

// What a pad says of the surface. Points, each in a triangle of the body, and triangles between them.
struct ShownPad {
  PadShade shade = PadShade::springs;
  double least = 0,
         peak = 0;   // of a(y) (solver/body/pad.hpp) [N/m^3]; of the stiffness [N/m]; of the error [1]
  double depth = 0;  // of the error [m]
  double share = 0;  // of the surface, where the error is above the tolerance [1]
  std::vector<std::uint32_t> facet;  // #P: number of its triangle of the body
  std::vector<Vec3> at;              // #P: barycentric coordinates in it
  std::vector<double> weight;        // #P: 0 at the least value, 1 at the peak and beyond
  std::vector<Triangle> triangles;   // of points, outward; those without springs are left out
};

// The surface of a body at rest.
struct ShownBody {
  std::vector<Vec3> nodes;          // #V [m]
  std::vector<Triangle> triangles;  // outward
  std::vector<NodeIndex> node;      // #V: number in the mesh, from 0
  std::vector<Role> role;           // #V
  std::vector<ShownGroup> groups;   // named node sets of the mesh that reach the surface
  ShownRegions regions;
  Vec3 rest = Vec3::Zero();     // where the contact rests, in the mesh [m]
  std::optional<Vec3> outward;  // mean normal of the contact
  std::optional<ShownPad> pad;  // then no node has the role contact
  TetMesh mesh;                 // for the .vtu; no tetrahedra for a surface
};

struct ShownState {
  State state;
  Label label = Label::blank;  // of its place, all states known
  double known = unknown;      // when it became known in the run [s]; NaN: from the start, or no run
};

// Labels at the centres of equal cells of a box, x fastest, then y, then z.
struct LabelGrid {
  double time = 0;  // [s] of the run; 0 without a run
  std::array<std::uint32_t, 3> count{};
  std::vector<Label> label;
};

struct ShownStates {
  std::vector<ShownState> all;    // in the order of the file
  std::vector<LabelGrid> labels;  // over `box`, by rising time
  RegionSummary regions;          // all states known
};

struct ShownFrame {
  double t = 0;                                 // [s]
  Vec3 at = Vec3::Zero(), sent = Vec3::Zero();  // [m], [N]
  Label label = Label::blank;
  double error = unknown;  // relative; NaN where not sampled
  double known = 0;        // number of known states
  bool trusted = false;    // the force is that of energy jets within their trust
};

// The shape of the surface at some times of a run.
struct ShownShape {
  double t = 0;             // [s]
  std::vector<Vec3> moved;  // #V: displacement of the surface's nodes [m]
};

struct ShownRun {
  std::vector<ShownFrame> path;  // thinned to what a screen can show
  std::vector<ShownShape> shapes;
  std::size_t frames = 0;  // of the run
};

struct ShowContent {
  std::string kind;   // "scene", "mesh", "surface", "states" or "run"
  std::string title;  // one line
  std::optional<ShownBody> body;
  std::optional<Box> box;    // of the states [m]
  double spacing = unknown;  // [m]
  std::optional<ShownStates> states;
  std::optional<ShownRun> run;
  std::vector<std::string> warnings;
};

// The box around all that is shown [m].
Box extent_of(const ShowContent& content);

// The initial view: azimuth about z, from x towards y, and elevation of the eye [degrees]. view_of() chooses it so that
// the contact is visible.
struct ViewPoint {
  double azimuth = -60, elevation = 24;
};
ViewPoint view_of(const ShowContent& content);

}  // namespace forefeel
