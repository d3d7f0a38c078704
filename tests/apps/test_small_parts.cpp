#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "apps/classify/run_table.hpp"
#include "apps/console/json.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene_input/sha256.hpp"
#include "geometry/common/error.hpp"
#include "tests/support/executable.hpp"

using namespace forefeel;

TEST_CASE("SHA-256 of the standard's examples", "[sha256]") {
  CHECK(Sha256{}.hex() == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(Sha256{}.add("abc").hex() == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(Sha256{}.add("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex() ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  Sha256 million;
  for (int i = 0; i < 1000; ++i) million.add(std::string(1000, 'a'));
  CHECK(million.hex() == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("SHA-256 does not depend on how the bytes are cut", "[sha256]") {
  const std::string text(1000, 'x');
  const std::string whole = Sha256{}.add(text).hex();
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    Sha256 parts;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t n = std::min<std::size_t>(random() % 150, text.size() - at);
      parts.add(std::string_view(text).substr(at, n));
      at += n;
    }
    CHECK(parts.hex() == whole);
  }
  CHECK(Sha256{}.add(0.0).hex() == Sha256{}.add(-0.0).hex());
  CHECK(Sha256{}.add(1.0).hex() != Sha256{}.add(std::int64_t{1}).hex());
}

TEST_CASE("edit distance and the nearest word", "[suggest]") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("poison", "poisson") == 1);
  CHECK(edit_distance("polciy", "policy") == 1);  // a swap of neighbours is one slip
  CHECK(edit_distance("Policy", "policy") == 0);
  CHECK(edit_distance("abc", "") == 3);
  const std::vector<std::string> known{"young", "poisson", "law"};
  CHECK(nearest_word("poison", known) == "poisson");
  CHECK(nearest_word("yuong", known) == "young");
  CHECK(nearest_word("x", {}).empty());
  CHECK(listed(known) == "young, poisson, law");
}

TEST_CASE("vectors as options", "[command]") {
  CHECK(parse_vector("1,2,3", "--at") == Eigen::Vector3d(1, 2, 3));
  CHECK(parse_vector("-0.01, 1e-3,-.5", "--at") == Eigen::Vector3d(-0.01, 1e-3, -0.5));
  for (const char* text :
       {"", "1", "1,2", "1,2,", "1,2,3,", "1,2,3,4", "nan,0,0", "0,-inf,0", "1 2 3", "1,2,3x", "0x1,0,0"})
    CHECK_THROWS_AS(parse_vector(text, "--at"), InputError);
}

TEST_CASE("numbers that JSON has no word for are null", "[command]") {
  CHECK(number(1.5) == 1.5);
  CHECK(number(std::numeric_limits<double>::infinity()).is_null());
  CHECK(number(std::numeric_limits<double>::quiet_NaN()).is_null());
  CHECK(vector3(Eigen::Vector3d(1, NAN, 3)).dump() == "[1.0,null,3.0]");
}

TEST_CASE("tables of a run", "[report]") {
  const test::Workshop shop;
  const RunTable table = RunTable::read(shop.write("a.csv", "t,label,e\r\n0,safe,\n1,gap,0.5\n"));
  CHECK(table.rows() == 2);
  CHECK(table.text(1, "label") == "gap");
  CHECK(table.number(1, "e") == 0.5);
  CHECK(std::isnan(table.number(0, "e")));
  CHECK(std::isnan(table.number(0, "absent")));
  CHECK_FALSE(table.has("absent"));
  CHECK_THROWS_AS(RunTable::read(shop.write("b.csv", "a,b\n1\n")), InputError);
  CHECK_THROWS_AS(RunTable::read(shop.write("c.csv", "")), InputError);
}

TEST_CASE("a thinned curve keeps its extremes", "[report]") {
  std::vector<double> x, y;
  for (int i = 0; i < 10000; ++i)
    x.push_back(i), y.push_back(i == 5000 ? 9 : i == 7001 ? -4 : i == 3 ? NAN : 0);
  const std::string lines = thinned_curve(x, y, 100);
  CHECK_THAT(lines, Catch::Contains("5000 9\n") && Catch::Contains("7001 -4\n") && !Catch::Contains("nan"));
  CHECK(std::count(lines.begin(), lines.end(), '\n') <= 200);
  CHECK(thinned_curve({}, {}, 100).empty());
}
