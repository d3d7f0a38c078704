#include "apps/console/command.hpp"
#include "apps/console/json.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/plot.hpp"
#include "tests/support/test.hpp"

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
  CHECK(nearest_word("nosuch", std::vector<std::string>{"error", "session"}).empty());
  CHECK(nearest_word("x", known).empty());  // two edits make a new word of it
  CHECK(nearest_word("neigbour_numbers", std::vector<std::string>{"neighbours"}).empty());
  CHECK(expected_instead("nosuch", known) == ", expected one of young, poisson, law");
  CHECK(expected_instead("lwa", known, "material.") ==
        ", did you mean 'material.law'? Expected one of young, poisson, law");
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

TEST_CASE("a thinned curve keeps its extremes", "[report]") {
  std::vector<double> x, y;
  for (int i = 0; i < 10000; ++i)
    x.push_back(i), y.push_back(i == 5000 ? 9 : i == 7001 ? -4 : i == 3 ? NAN : 0);
  const std::string lines = thinned_curve(x, y, 100);
  CHECK_THAT(lines, Contains("5000 9\n", "7001 -4\n") && !Contains("nan"));
  CHECK(std::count(lines.begin(), lines.end(), '\n') <= 200);
  CHECK(thinned_curve({}, {}, 100).empty());
}
