// One row declares a key: of a table of a scene (scene_rows.hpp), of a JSON document (document_keys.hpp), and a column
// of a CSV file (geometry/common/field.hpp).

#include "apps/console/document_keys.hpp"
#include "apps/scene/scene_rows.hpp"
#include "geometry/common/field.hpp"
#include "tests/support/test.hpp"

namespace {

struct Inner {
  double share = 0.5;
};
struct Sample {
  double length = 2;
  int count = 3;
  bool open = true;
  std::optional<double> limit;
  Clock clock = Clock::real;
  Inner inner;
};

const SceneRows<Inner>& inner_rows() {
  static const auto rows = SceneRows<Inner>("sample.inner", "A table in it.")
                               .number("share", "1", share(), "of the whole", &Inner::share)
                               .required("a share");
  return rows;
}

const SceneRows<Sample>& sample_rows() {
  using S = Sample;
  static const auto rows = SceneRows<S>("sample", "A sample.")
                               .number("length", "m", positive(), "along x", &S::length)
                               .whole("count", 1, 9, "of them", &S::count)
                               .only_solving()
                               .flag("open", "at the end", &S::open)
                               .number("limit", "N", positive(), "of the force", &S::limit)
                               .standard("none")
                               .word("clock", clock_words, "", &S::clock)
                               .row({"other", "", "", "read elsewhere"})
                               .alternative()
                               .table("inner", "table: more", inner_rows(), &S::inner);
  return rows;
}

// The options, or the error.
std::string read(const std::string& text, Sample& sample) {
  const SceneDocument document = SceneDocument::parse(text, "file", {});
  try {
    const SceneTable table = document.root({"sample"}).sub("sample", sample_rows().names());
    sample_rows().read(table, sample);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

struct Point {
  Vec3 at;
  double error;
  std::vector<Inner> parts;
};

}  // namespace

TEST_CASE("a row of a scene is read, checked and documented", "[scene]") {
  Sample sample;
  CHECK(read("[sample]\nlength = 5\ncount = 4\nopen = false\nlimit = 2\nclock = \"virtual\"\ninner.share = "
             "0.1\n",
             sample) == "");
  CHECK(sample.length == 5);
  CHECK(sample.count == 4);
  CHECK_FALSE(sample.open);
  CHECK(sample.limit == 2.0);
  CHECK(sample.clock == Clock::virtual_time);
  CHECK(sample.inner.share == 0.1);
  Sample usual;
  CHECK(read("[sample]\n", usual) == "");
  CHECK(usual.length == 2);
  CHECK_FALSE(usual.limit);
  CHECK_THAT(read("[sample]\nlength = -1\n", usual), Contains("file:2: sample.length", "a number above 0"));
  CHECK_THAT(read("[sample]\ncount = 10\n", usual), Contains("a whole number from 1 to 9"));
  CHECK_THAT(read("[sample]\nlenght = 1\n", usual), Contains("did you mean 'sample.length'"));
  CHECK_THAT(read("[sample]\nclock = \"vitrual\"\n", usual), Contains("nearest: 'virtual'"));

  const std::vector<DeclaredTable>& tables = sample_rows().tables();
  REQUIRE(tables.size() == 2);
  const std::vector<Declared>& help = tables[0].rows;
  REQUIRE(help.size() == 7);
  CHECK(help[0].unit == "m");
  CHECK(help[0].standard == "2");
  CHECK(help[2].standard == "true");
  CHECK(help[3].standard == "none");
  CHECK(help[4].standard == "real");
  CHECK(help[4].meaning == "real | virtual");
  CHECK(tables[1].name == "sample.inner");
  CHECK(tables[1].rows[0].standard == "required");
  CHECK(sample_rows().of_solving() == std::vector<std::string>{"count"});
  CHECK(sample_rows().alternatives() == std::vector<std::string>{"other"});
}

TEST_CASE("a required key that is missing is an error", "[scene]") {
  const SceneDocument document = SceneDocument::parse("[sample]\n", "file", {});
  const SceneTable table = document.root({"sample"}).sub("sample", inner_rows().names());
  CHECK_THROWS_WITH(inner_rows().check_required(table),
                    Contains("sample.share", "missing, expected a share"));
}

TEST_CASE("a row of a document is written and documented") {
  using P = Point;
  const JsonKeys<Inner> inner{{"share", "1", "of the whole", &Inner::share}};
  const JsonKeys<P> keys{
      {"error.p50,p95", "1", "of it",
       [](const P& p) {
         return json_numbers({p.error, 2 * p.error});
       }},
      {"at", "m", "position", &P::at},
      json_list<P>("parts", inner, &P::parts, "list of parts").last(),
      {"by.LABEL", "", "of each label",
       [](const P&) {
         return Json{{"safe", 1}, {"gap", 2}};
       }},
      {"absent", "", "only sometimes", [](const P&) { return std::optional<double>(); }},
      json_object<P>("none", inner, "null: there is none", [](const P&) -> const Inner* { return nullptr; }),
      {"elsewhere", "", "written by other code"}};
  const P point{Vec3(1, 2, std::numeric_limits<double>::infinity()), 0.5, {{0.25}, {0.75}}};
  CHECK(document_of(keys, point).dump() ==
        R"({"error":{"p50":0.5,"p95":1.0},"at":[1.0,2.0,null],"parts":[{"share":0.25},{"share":0.75}],)"
        R"("by":{"safe":1,"gap":2},"none":null})");
  CHECK(names_of(declared(keys)) == std::vector<std::string>{"error.p50,p95", "at", "by.LABEL", "absent",
                                                             "none", "none.share", "elsewhere", "parts",
                                                             "parts[].share"});
}

TEST_CASE("a column of a CSV file is written and documented") {
  constexpr Field<Point> columns[] = {
      {"x,y,z", "m", "position", [](Cells& o, const Point& p) { put(o, p.at); }},
      {"error", "1", "of it", [](Cells& o, const Point& p) { put(o, p.error); }}};
  CHECK(header_of<Point>(columns) == "x,y,z,error\n");
  CHECK(csv_row<Point>(columns, {Vec3(1, 2, 3), unknown, {}}) == "1,2,3,\n");
  CHECK(csv_row<Point>(columns, {Vec3(1, 2, 3), 0.5, {}}) == "1,2,3,0.5\n");
  CHECK(declared<Point>(columns)[1].unit == "1");
}
