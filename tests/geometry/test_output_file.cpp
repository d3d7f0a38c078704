// Output files: links and file modes are kept, and the user's own files are not replaced.

#include <sys/stat.h>

#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "tests/support/test.hpp"

namespace {

void write(const fs::path& file, const char* text) {
  OutputFile out(file);
  out.write(text);
  out.commit();
}

unsigned mode_of(const fs::path& file) {
  struct stat status {};
  REQUIRE(::stat(file.c_str(), &status) == 0);
  return status.st_mode & 07777u;
}

}  // namespace

TEST_CASE("a symbolic link stays, and the file that it leads to is written") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "far");
  const auto target = folder.write("far/target.csv", "old"), link = folder / "link.csv";
  fs::create_symlink("far/target.csv", link);
  fs::create_symlink("link.csv", folder / "second.csv");
  write(folder / "second.csv", "new");
  CHECK(fs::is_symlink(link));
  CHECK(fs::is_symlink(folder / "second.csv"));
  CHECK(text_of(target) == "new");

  fs::create_symlink("far/absent.csv", folder / "open.csv");  // its target is made
  write(folder / "open.csv", "first");
  CHECK(fs::is_symlink(folder / "open.csv"));
  CHECK(text_of(folder / "far/absent.csv") == "first");

  fs::create_symlink("no/such/folder.csv", folder / "lost.csv");
  CHECK_THAT(error_of([&] { write(folder / "lost.csv", ""); }), Contains("does not exist"));
  fs::create_symlink("round.csv", folder / "round.csv");
  CHECK_THAT(error_of([&] { write(folder / "round.csv", ""); }), Contains("in a circle"));
}

TEST_CASE("a file that is replaced keeps its mode") {
  const TemporaryFolder folder;
  for (const unsigned mode : {0600u, 0640u, 0664u}) {
    const auto file = folder.write("secret.csv", "old");
    REQUIRE(::chmod(file.c_str(), mode) == 0);
    write(file, "new");
    CHECK(mode_of(file) == mode);
    CHECK(text_of(file) == "new");
  }
}

TEST_CASE("a folder with somebody's own file of a name that would be written is refused") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "mine");
  const auto own = folder.write("mine/report.html", "my own");
  const auto claim = [&](const fs::path& at) {
    return error_of([&] { claim_folder(at, {"report.html", "*.csv"}); });
  };
  CHECK_THAT(claim(folder / "mine"), Contains("report.html: is there already and was not made by forefeel"));
  CHECK_FALSE(fs::exists(folder / "mine/.forefeel"));
  CHECK(text_of(own) == "my own");
  fs::remove(own);
  folder.write("mine/notes.txt", "my own");  // no name of ours
  CHECK(claim(folder / "mine").empty());
  folder.write("mine/report.html", "ours");
  CHECK(claim(folder / "mine").empty());  // a later run replaces it
  CHECK_THAT(error_of([&] { claim_folder(folder / "mine", {"*.txt"}); }), Contains("notes.txt"));

  fs::create_directory(folder / "other");
  folder.write("other/table.csv", "my own");
  CHECK_THAT(claim(folder / "other"), Contains("table.csv"));
}

TEST_CASE("a folder that an older version filled, without the marker, is taken") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "run");
  folder.write("run/report.html", "ours");
  folder.write("run/summary.json", R"({"provenance": {"commit": "x", "scene_hash": "y"}})");
  claim_folder(folder / "run", {"report.html", "summary.json"});
  CHECK(fs::exists(folder / "run/.forefeel"));
}
