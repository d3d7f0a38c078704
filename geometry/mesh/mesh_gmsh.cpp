// Gmsh .msh, as its reference manual describes the formats 1 ($NOD, $ELM), 2.2 and 4.1. Node tags may be any
// numbers; nodes are numbered here in file order. Physical groups of any dimension become node groups, those of
// dimension 3 also element groups.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <unordered_map>

#include "geometry/common/error.hpp"
#include "geometry/mesh/gmsh_scanner.hpp"
#include "geometry/mesh/mesh_formats.hpp"

namespace forefeel {
namespace {

class GmshReader : GmshScanner {
 public:
  explicit GmshReader(Scanner in) : GmshScanner(std::move(in)) {}

  TetMesh read() {
    if (in_.peek() == "$NOD")
      read_version_1();
    else
      read_sections();
    if (!seen_nodes_) throw InputError({.file = in_.name()}, "holds no $Nodes section");
    if (!seen_elements_) throw InputError({.file = in_.name()}, "holds no $Elements section");
    for (const auto& [group, nodes] : physical_) {
      if (group.first == 3 && covers_all(nodes))
        continue;  // a group of the whole body carries no information
      auto& target = mesh_.groups[name_of(group)];
      target.insert(target.end(), nodes.begin(), nodes.end());
    }
    for (const auto& [group, tets] : volumes_) {
      if (tets.size() == mesh_.tets.size() && !names_.contains(group)) continue;
      auto& target = mesh_.element_groups[name_of(group)];
      target.insert(target.end(), tets.begin(), tets.end());
    }
    return std::move(mesh_);
  }

 private:
  using Group = std::pair<int, std::int64_t>;  // dimension, physical tag

  std::string name_of(const Group& group) const {
    const auto named = names_.find(group);
    return named != names_.end() ? named->second : fmt::format("physical_{}_{}", group.first, group.second);
  }

  void read_sections() {
    read_format();
    while (!in_.at_end()) {
      const std::string section(in_.token("a section"));
      if (section.size() < 2 || section[0] != '$')
        in_.fail(fmt::format("'{:.40}' stands where a $Section was expected", section));
      read_section(section.substr(1));
    }
  }

  // $NOD n, lines "number x y z", $ENDNOD; $ELM n, lines "number type physical elementary count nodes", $ENDELM.
  void read_version_1() {
    while (!in_.at_end()) {
      const std::string section(in_.token("a section"));
      if (section == "$NOD") {
        begin_nodes();
        const std::size_t n = in_.count("a number of nodes", 8);
        mesh_.nodes.reserve(n), index_.reserve(n);
        for (std::size_t i = 0; i < n; ++i) {
          const std::int64_t tag = in_.integer("a node number");
          const double x = in_.real("x"), y = in_.real("y"), z = in_.real("z");
          add_node(tag, {x, y, z});
        }
        end_section_1("$ENDNOD");
      } else if (section == "$ELM") {
        read_elements_1();
        end_section_1("$ENDELM");
      } else {
        in_.fail(fmt::format("'{:.40}' stands where $NOD or $ELM was expected", section));
      }
    }
  }

  void read_elements_1() {
    begin_elements();
    const std::size_t n = in_.count("a number of elements", 10);
    for (std::size_t i = 0; i < n; ++i) {
      in_.integer("an element number");
      const GmshElement type = known_type(in_.integer("an element type"));
      const std::int64_t physical = in_.integer("a physical region");
      in_.integer("an elementary region");
      if (const std::int64_t nodes = in_.integer("a number of nodes"); nodes != type.nodes)
        in_.fail(fmt::format("an element of {} nodes, expected {} for its type", nodes, type.nodes));
      scratch_.resize(static_cast<std::size_t>(type.nodes));
      for (auto& index : scratch_) index = node(in_.integer("a node number"));
      add_element(type, scratch_, {&physical, 1});
    }
  }

  void end_section_1(const char* end) {
    const auto word = in_.token("the end of a section");
    if (word != end) in_.fail(fmt::format("'{:.40}' stands where {} was expected", word, end));
  }

  bool covers_all(const std::vector<NodeIndex>& nodes) const {
    std::vector<char> left = used_nodes(mesh_);
    for (const NodeIndex node : nodes) left[node] = 0;
    return std::ranges::none_of(left, [](char c) { return c != 0; });
  }

  void read_format() {
    if (in_.token("$MeshFormat") != "$MeshFormat")
      in_.fail("is not a Gmsh file, expected $MeshFormat (or $NOD of format 1)");
    const std::string version(in_.token("a format version"));
    four_ = version == "4.1";
    if (!four_ && version != "2.2" && version != "2" && version != "2.1" && version != "2.0")
      in_.fail(fmt::format(
          "Gmsh format {:.20} is not read, expected 1, 2.2 or 4.1; gmsh {} -save -o NEW.msh writes "
          "it again",
          version, in_.name()));
    binary_ = in_.integer("0 (ASCII) or 1 (binary)", 0, 1) == 1;
    const auto size = in_.integer("the size of a number", 1, 16);
    if (size != 8) in_.fail(fmt::format("numbers of {} bytes, expected 8", size));
    if (binary_) {
      next_line();
      const auto one = in_.raw<std::int32_t>("the number 1");
      if (one != 1 && one != 0x01000000) in_.fail_binary("the byte order mark is wrong, expected 1");
      in_.swap_bytes(one != 1);
    }
    end_section("MeshFormat");
  }

  void read_section(const std::string& section) {
    if (section == "PhysicalNames")
      read_physical_names();
    else if (section == "Entities" && four_)
      read_entities();
    else if (section == "PartitionedEntities" && four_)
      read_partitioned_entities();
    else if (section == "Nodes")
      four_ ? read_nodes_4() : read_nodes_2();
    else if (section == "Elements")
      four_ ? read_elements_4() : read_elements_2();
    else if (section == "ParametricNodes")
      in_.fail("$ParametricNodes is not read, expected $Nodes");
    else
      skip_section(section);
  }

  void skip_section(const std::string& section) {
    const InputPlace where = in_.where();
    // Binary data need no line break before their end.
    if (!(binary_ ? in_.skip_past_word("$End" + section) : in_.skip_past_line("$End" + section)))
      throw InputError(where, fmt::format("section ${:.40} has no end", section));
  }

  void read_physical_names() {
    const std::size_t n = in_.count("a number of names", 4);
    for (std::size_t i = 0; i < n; ++i) {
      const int dimension = static_cast<int>(in_.integer("a dimension", 0, 3));
      const std::int64_t tag = in_.integer("a physical tag");
      std::string_view rest;
      if (!in_.line(rest)) in_.fail("the file ends where a name was expected");
      rest = trimmed(rest);
      if (rest.size() < 2 || rest.front() != '"' || rest.back() != '"')
        in_.fail("a name in quotes was expected");
      names_[{dimension, tag}] = std::string(rest.substr(1, rest.size() - 2));
    }
    end_section("PhysicalNames");
  }

  void read_entities() {
    if (binary_) next_line();
    std::size_t counts[4];
    for (auto& n : counts) n = size_count("a number of entities", 4, 8);
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts[dimension]; ++i) {
        const std::int64_t tag = whole("an entity tag");
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) real("a bound of the entity");
        const std::size_t n = size_count("a number of physical tags", 2, 4);
        auto& tags = entity_[{dimension, tag}];
        for (std::size_t k = 0; k < n; ++k) tags.push_back(whole("a physical tag"));
        if (dimension == 0) continue;
        const std::size_t bounds = size_count("a number of bounding entities", 2, 4);
        for (std::size_t k = 0; k < bounds; ++k) whole("a bounding entity");
      }
    end_section("Entities");
  }

  // Partitions have entities of their own, to which the elements refer. Each names its parent, whose groups it shares.
  void read_partitioned_entities() {
    if (binary_) next_line();
    size("a number of partitions");
    const std::size_t ghosts = size_count("a number of ghost entities", 4, 8);
    for (std::size_t i = 0; i < ghosts; ++i) whole("a ghost entity"), whole("a partition");
    std::size_t counts[4];
    for (auto& n : counts) n = size_count("a number of entities", 4, 8);
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts[dimension]; ++i) {
        const std::int64_t tag = whole("an entity tag");
        const std::int64_t parent_dimension = whole("the dimension of the parent"),
                           parent = whole("the parent");
        const std::size_t partitions = size_count("a number of partitions", 2, 4);
        for (std::size_t k = 0; k < partitions; ++k) whole("a partition");
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) real("a bound of the entity");
        std::vector<std::int64_t> tags(size_count("a number of physical tags", 2, 4));
        for (std::int64_t& physical : tags) physical = whole("a physical tag");
        if (const auto known = entity_.find({static_cast<int>(parent_dimension), parent});
            tags.empty() && parent_dimension == dimension && known != entity_.end())
          tags = known->second;
        partition_[{dimension, tag}] = std::move(tags);
        if (dimension == 0) continue;
        const std::size_t bounds = size_count("a number of bounding entities", 2, 4);
        for (std::size_t k = 0; k < bounds; ++k) whole("a bounding entity");
      }
    for (auto& [entity, tags] : partition_) entity_[entity] = tags;
    end_section("PartitionedEntities");
  }

  void add_node(std::int64_t tag, const Vec3& position) {
    if (!index_.emplace(tag, static_cast<NodeIndex>(mesh_.nodes.size())).second)
      fail(fmt::format("node {} is there twice", tag));
    mesh_.nodes.push_back(position);
  }

  void begin_nodes() {
    if (seen_nodes_) in_.fail("there is a second $Nodes section, expected one");
    seen_nodes_ = true;
  }

  void read_nodes_2() {
    begin_nodes();
    const std::size_t n = in_.count("a number of nodes", binary_ ? 28 : 8);
    if (binary_) next_line();
    mesh_.nodes.reserve(n), index_.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t tag = whole("a node number");
      const double x = real("x"), y = real("y"), z = real("z");
      add_node(tag, {x, y, z});
    }
    end_section("Nodes");
  }

  void read_nodes_4() {
    begin_nodes();
    if (binary_) next_line();
    const std::size_t blocks = size_count("a number of blocks", 6, 20),
                      n = size_count("a number of nodes", 7, 32);
    size("the least node tag"), size("the greatest node tag");
    mesh_.nodes.reserve(n), index_.reserve(n);
    std::vector<std::int64_t> tags;
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::int64_t dimension = whole("a dimension");
      whole("an entity tag");
      const std::int64_t parametric = whole("0 or 1 (parametric)");
      if (dimension < 0 || dimension > 3) fail(fmt::format("{} is no dimension, expected 0 to 3", dimension));
      tags.assign(size_count("a number of nodes", 7, 32), 0);
      for (auto& tag : tags) tag = size("a node tag");
      for (const auto tag : tags) {
        const double x = real("x"), y = real("y"), z = real("z");
        for (std::int64_t k = 0; parametric != 0 && k < dimension; ++k) real("a parameter");
        add_node(tag, {x, y, z});
      }
    }
    if (mesh_.nodes.size() != n)
      fail(fmt::format("{} nodes were announced, {} found", n, mesh_.nodes.size()));
    end_section("Nodes");
  }

  NodeIndex node(std::int64_t tag) {
    const auto found = index_.find(tag);
    if (found == index_.end()) fail(fmt::format("an element names node {}, which is not in $Nodes", tag));
    return found->second;
  }

  void begin_elements() {
    if (!seen_nodes_) in_.fail("$Elements stands before $Nodes");
    seen_elements_ = true;
  }

  GmshElement known_type(std::int64_t type) {
    const GmshElement result = gmsh_element(type);
    if (result.nodes == 0) fail(fmt::format("element type {} is unknown", type));
    if (result.dimension == 3 && result.nodes != 4 && result.nodes != second_order_nodes)
      fail(fmt::format("{} (element type {}) are not read, {}", gmsh_element_name(type), type,
                       not_tetrahedra));
    return result;
  }

  void add_element(const GmshElement& type, std::span<const NodeIndex> nodes,
                   std::span<const std::int64_t> groups) {
    if (type.dimension == 3) {
      const Tet corners{nodes[0], nodes[1], nodes[2], nodes[3]};
      if (type.nodes == second_order_nodes)
        add_second_order(mesh_, corners, {nodes[4], nodes[5], nodes[6], nodes[7], nodes[9], nodes[8]});
      else
        mesh_.tets.push_back(corners);
    }
    for (const auto tag : groups)
      if (tag != 0) {
        if (type.dimension == 3)
          volumes_[{type.dimension, tag}].push_back(static_cast<TetIndex>(mesh_.tets.size() - 1));
        auto& group = physical_[{type.dimension, tag}];
        group.insert(group.end(), nodes.begin(), nodes.end());
      }
  }

  void read_element_2(std::int64_t type, std::int64_t tags) {
    const GmshElement known = known_type(type);
    std::int64_t physical = 0;
    for (std::int64_t k = 0; k < tags; ++k) {
      const std::int64_t tag = whole("a tag");
      if (k == 0) physical = tag;
    }
    scratch_.resize(static_cast<std::size_t>(known.nodes));
    for (auto& index : scratch_) index = node(whole("a node number"));
    add_element(known, scratch_, {&physical, 1});
  }

  void read_elements_2() {
    begin_elements();
    const std::size_t n = in_.count("a number of elements", binary_ ? 8 : 6);
    if (binary_) next_line();
    for (std::size_t i = 0; i < n;) {
      if (!binary_) in_.integer("an element number");
      const std::int64_t type = whole("an element type");
      const std::int64_t follow = binary_ ? whole("a number of elements") : 1;
      const std::int64_t tags = whole("a number of tags");
      if (tags < 0 || tags > 1000) fail(fmt::format("{} tags, expected 0 to 1000", tags));
      if (follow < 1 || static_cast<std::size_t>(follow) > n - i)
        fail(fmt::format("a block of {} elements does not fit", follow));
      for (std::int64_t k = 0; k < follow; ++k) {
        if (binary_) in_.raw<std::int32_t>("an element number");
        read_element_2(type, tags);
      }
      i += static_cast<std::size_t>(follow);
    }
    end_section("Elements");
  }

  void read_elements_4() {
    begin_elements();
    if (binary_) next_line();
    const std::size_t blocks = size_count("a number of blocks", 6, 20),
                      n = size_count("a number of elements", 4, 16);
    size("the least element tag"), size("the greatest element tag");
    std::size_t found = 0;
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::int64_t dimension = whole("a dimension"), entity = whole("an entity tag");
      const GmshElement type = known_type(whole("an element type"));
      const std::size_t count = size_count("a number of elements", 4, 16);
      const auto physical = entity_.find({static_cast<int>(dimension), entity});
      const std::span<const std::int64_t> groups = physical == entity_.end()
                                                       ? std::span<const std::int64_t>{}
                                                       : std::span<const std::int64_t>(physical->second);
      for (std::size_t k = 0; k < count; ++k) {
        size("an element tag");
        scratch_.resize(static_cast<std::size_t>(type.nodes));
        for (auto& index : scratch_) index = node(size("a node tag"));
        add_element(type, scratch_, groups);
      }
      found += count;
    }
    if (found != n) fail(fmt::format("{} elements were announced, {} found", n, found));
    end_section("Elements");
  }

  bool four_ = false, seen_nodes_ = false, seen_elements_ = false;
  TetMesh mesh_;
  std::unordered_map<std::int64_t, NodeIndex> index_;  // node tag -> number here
  std::map<Group, std::vector<std::int64_t>> entity_;  // 4.1: dimension, entity -> physical tags
  std::map<Group, std::vector<std::int64_t>> partition_;
  std::map<Group, std::string> names_;
  std::map<Group, std::vector<NodeIndex>> physical_;
  std::map<Group, std::vector<TetIndex>> volumes_;
  std::vector<NodeIndex> scratch_;
};

}  // namespace

TetMesh read_gmsh(Scanner in) {
  return GmshReader(std::move(in)).read();
}

}  // namespace forefeel
