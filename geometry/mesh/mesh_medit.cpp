// Medit .mesh (ASCII): "MeshVersionFormatted v", "Dimension 3", then keyword sections of n lines. Reference
// numbers other than 0 of vertices, triangles and tetrahedra become node groups ref_vertices_R,
// ref_triangles_R, …, those of tetrahedra also element groups.

#include <fmt/format.h>

#include <map>

#include "geometry/common/error.hpp"
#include "geometry/mesh/mesh_formats.hpp"

namespace forefeel {
namespace {

// Number of integers in a line of the section, reference included; 0: unknown section.
unsigned integers_per_line(const std::string& keyword) {
  static const std::map<std::string, unsigned> known{{"edges", 3},
                                                     {"triangles", 4},
                                                     {"quadrilaterals", 5},
                                                     {"tetrahedra", 5},
                                                     {"corners", 1},
                                                     {"ridges", 1},
                                                     {"requiredvertices", 1},
                                                     {"requirededges", 1},
                                                     {"requiredtriangles", 1},
                                                     {"requiredquadrilaterals", 1},
                                                     {"requiredtetrahedra", 1}};
  const auto found = known.find(keyword);
  return found == known.end() ? 0 : found->second;
}

// Number of values in a line of the section, of which the first `integers` are whole numbers.
int reals_per_line(const std::string& keyword) {
  static const std::map<std::string, int> known{{"normals", 3},
                                                {"tangents", 3},
                                                {"normalatvertices", 2},
                                                {"tangentatvertices", 2},
                                                {"normalattrianglevertices", 3},
                                                {"tangentatedgevertices", 3},
                                                {"normalatquadrilateralvertices", 3}};
  const auto found = known.find(keyword);
  return found == known.end() ? 0 : found->second;
}

class MeditReader {
 public:
  explicit MeditReader(Scanner in) : in_(std::move(in)) { in_.comment('#'); }

  TetMesh read() {
    if (lower_case(in_.token("MeshVersionFormatted")) != "meshversionformatted")
      in_.fail("is not a Medit file, expected MeshVersionFormatted");
    in_.integer("a version", 0, 4);
    bool ended = false;
    while (!ended && !in_.at_end()) {
      const std::string keyword = lower_case(in_.token("a keyword"));
      if (keyword == "end")
        ended = true;
      else if (keyword == "dimension")
        in_.integer("dimension 3", 3, 3);
      else if (keyword == "vertices")
        read_vertices();
      else if (const unsigned n = integers_per_line(keyword); n > 0)
        read_elements(keyword, n);
      else if (const int m = reals_per_line(keyword); m > 0)
        skip_reals(m);
      else if (keyword == "hexahedra" || keyword == "hexaedra" || keyword == "prisms" ||
               keyword == "pyramids")
        refuse(keyword);
      else
        in_.fail(fmt::format("keyword '{:.40}' is unknown, expected a Medit section", keyword));
    }
    if (!ended && !seen_tetrahedra_)
      throw InputError({.file = in_.name()}, "ends before its Tetrahedra section, the file is cut short");
    if (!seen_vertices_) throw InputError({.file = in_.name()}, "holds no Vertices section");
    resolve();
    return std::move(mesh_);
  }

 private:
  void refuse(const std::string& keyword) {
    if (in_.count("a number of elements", 2) > 0) in_.fail(keyword + " are not read, " + not_tetrahedra);
  }

  void read_vertices() {
    if (seen_vertices_) in_.fail("there is a second Vertices section, expected one");
    seen_vertices_ = true;
    const std::size_t n = in_.count("a number of vertices", 8);
    mesh_.nodes.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = in_.real("x"), y = in_.real("y"), z = in_.real("z");
      mesh_.nodes.emplace_back(x, y, z);
      if (const auto reference = in_.integer("a reference"); reference != 0)
        mesh_.groups[fmt::format("ref_vertices_{}", reference)].push_back(static_cast<NodeIndex>(i));
    }
  }

  void read_elements(const std::string& keyword, unsigned n_integers) {
    const std::size_t n = in_.count("a number of entries", 2 * n_integers);
    const bool tetrahedra = keyword == "tetrahedra", nodes = n_integers > 1;
    seen_tetrahedra_ = seen_tetrahedra_ || tetrahedra;
    for (std::size_t i = 0; i < n; ++i) {
      Tet element{};
      for (unsigned k = 0; k < n_integers - (nodes ? 1 : 0); ++k) {
        const auto node = in_.integer("a vertex number", 1, 0x7fffffff) - 1;
        if (nodes) greatest_ = std::max(greatest_, node);
        if (k < 4) element[k] = static_cast<NodeIndex>(node);
      }
      if (tetrahedra) mesh_.tets.push_back(element);
      const std::int64_t reference = nodes ? in_.integer("a reference") : 0;
      if (reference == 0) continue;
      const std::string name = fmt::format("ref_{}_{}", keyword, reference);
      if (tetrahedra) mesh_.element_groups[name].push_back(static_cast<TetIndex>(mesh_.tets.size() - 1));
      auto& group = mesh_.groups[name];
      group.insert(group.end(), element.begin(), element.begin() + (n_integers - 1));
    }
  }

  void skip_reals(int per_line) {
    const std::size_t n = in_.count("a number of entries", static_cast<std::size_t>(2 * per_line));
    for (std::size_t i = 0; i < n * static_cast<std::size_t>(per_line); ++i) in_.real("a number");
  }

  void resolve() const {
    if (greatest_ >= static_cast<std::int64_t>(mesh_.nodes.size()))
      throw InputError({.file = in_.name()}, fmt::format("an element names vertex {}, expected 1 to {}",
                                                         greatest_ + 1, mesh_.nodes.size()));
  }

  Scanner in_;
  TetMesh mesh_;
  bool seen_vertices_ = false, seen_tetrahedra_ = false;
  std::int64_t greatest_ = -1;
};

}  // namespace

TetMesh read_medit(Scanner in) {
  return MeditReader(std::move(in)).read();
}

}  // namespace forefeel
