// Readers of label volumes: every format gives the same volume, and false headers are refused.

#include "geometry/segmentation/label_volume.hpp"
#include "tests/support/label_samples.hpp"
#include "tests/support/test.hpp"

namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string problem_of(const fs::path& file) {
  return error_of([&] { read_label_volume(file); });
}

void check_same(const LabelVolume& read, const LabelVolume& expected) {
  CHECK(read.size == expected.size);
  CHECK(read.values == expected.values);
  CHECK(read.voxels == expected.voxels);
  CHECK((read.axes - 1e-3 * Vec3(1, 2, 3).asDiagonal().toDenseMatrix()).norm() < 1e-12);
  CHECK((read.origin - Vec3(0.010, 0.020, 0.030)).norm() < 1e-9);
}

}  // namespace

TEST_CASE("every format gives the same labels, spacing and place") {
  const LabelVolume expected = test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3);
  const TemporaryFolder folder;
  for (const auto& [name, content] : test::label_files(expected)) {
    INFO(name);
    check_same(read_label_volume(folder.write(name, content)), expected);
  }
}

TEST_CASE("gzip as the program makes it is read: .nii.gz and .nrrd") {
  if (!has_command("gzip")) return skip("gzip is not installed");
  const LabelVolume expected = test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3);
  const TemporaryFolder folder;
  const auto nifti = folder.write("a.nii", test::nifti_bytes(expected));
  const auto raw = folder.write("raw", test::label_bytes(expected));
  REQUIRE(std::system(("gzip '" + nifti.string() + "' '" + raw.string() + "'").c_str()) == 0);
  check_same(read_label_volume(folder / "a.nii.gz"), expected);
  folder.write("c.nhdr", replaced(replaced(test::label_files(expected)["c.nrrd"], "encoding: raw",
                                           "encoding: gzip\ndata file: raw.gz"),
                                  test::label_bytes(expected), ""));
  check_same(read_label_volume(folder / "c.nhdr"), expected);
  fs::resize_file(folder / "a.nii.gz", fs::file_size(folder / "a.nii.gz") - 20);
  CHECK_THAT(problem_of(folder / "a.nii.gz"), Contains("cut short"));
}

TEST_CASE("a turned volume is turned: rows of TransformMatrix are the directions of the axes") {
  const LabelVolume plain = test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3);
  const TemporaryFolder folder;
  const std::string mha = test::label_files(plain)["b.mha"];
  const auto file =
      folder.write("b.mha", replaced(mha, "Offset", "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset"));
  const LabelVolume turned = read_label_volume(file);
  CHECK((turned.position({1, 0, 0}) - turned.origin - Vec3(0, 0.001, 0)).norm() < 1e-12);
  CHECK((turned.position({0, 1, 0}) - turned.origin - Vec3(-0.002, 0, 0)).norm() < 1e-12);
}

TEST_CASE("headers that claim what is not there are one line each") {
  const LabelVolume plain = test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3);
  const TemporaryFolder folder;
  std::map<std::string, std::string> files = test::label_files(plain);
  const auto refused = [&](const std::string& name, const std::string& content, const std::string& mentions) {
    INFO(name << " " << mentions);
    CHECK_THAT(problem_of(folder.write(name, content)), Contains(mentions));
  };
  const std::string size = "9 7 6", huge = "1000000000 1000000000 1000000000",
                    bytes = test::label_bytes(plain);
  for (const char* name : {"b.mha", "c.nrrd", "d.nrrd"}) {
    refused(name, replaced(files[name], size, huge), "memory");
    refused(name, replaced(files[name], size, "-9 7 6"), "expected three positive sizes");
    refused(name, replaced(files[name], size, "9 7 60"), "cut short");
  }
  refused("b.mha", replaced(files["b.mha"], "MET_UCHAR", "MET_STRING"), "MET_STRING");
  refused("b.mha", replaced(files["b.mha"], "ElementSpacing = 1 2 3", "ElementSpacing = 1 0 3"),
          "voxels without a volume");
  refused("b.mha", replaced(files["b.mha"], "LOCAL", "/etc/passwd"), "same folder");
  refused("c.nrrd", replaced(files["c.nrrd"], "uchar", "block"), "block");
  refused("d.nrrd", replaced(files["d.nrrd"], "\n\n0", "\n\n0.5"), "whole numbers");
  refused("e.vti", replaced(files["e.vti"], "0 8 0 6 0 5", "0 80000 0 80000 0 80000"), "memory");
  std::string nifti = files["a.nii"];
  nifti[43] = '\x7f';  // 32521 voxels along x
  refused("a.nii", nifti, "cut short");
  nifti[43] = '\xff';
  refused("a.nii", nifti, "not positive");
  nifti = files["a.nii"];
  nifti[70] = 127;
  refused("a.nii", nifti, "data type 127");
  refused("a.nii", files["a.nii"].substr(0, 100), "cut short");
}

TEST_CASE("bytes behind the last voxel are left out, and counted") {
  const LabelVolume plain = test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3);
  const TemporaryFolder folder;
  std::map<std::string, std::string> files = test::label_files(plain);
  for (const char* name : {"a.nii", "b.mha", "c.nrrd"}) {
    INFO(name);
    CHECK(read_label_volume(folder.write(name, files[name])).warnings.empty());
    const LabelVolume longer = read_label_volume(folder.write(name, files[name] + "123"));
    CHECK(longer.voxels == plain.voxels);
    REQUIRE(longer.warnings.size() == 1);
    CHECK_THAT(longer.warnings[0], Contains("3 bytes behind the last voxel"));
  }
}

TEST_CASE("NIfTI: a code that is no unit is an unknown unit, 0 is none") {
  const TemporaryFolder folder;
  std::string nifti = test::nifti_bytes(test::nested_spheres({9, 7, 6}, {1, 2, 3}, 6, 3));
  nifti[123] = 8 + 7;  // 8: seconds
  CHECK(read_label_volume(folder.write("a.nii", nifti)).unit_unknown == "code 7");
  nifti[123] = 8;
  const LabelVolume none = read_label_volume(folder.write("a.nii", nifti));
  CHECK(none.unit_unknown.empty());
  CHECK_FALSE(none.unit_given);
}

TEST_CASE("an atlas of many labels is read; more values than labels can be are not") {
  const auto values = [](int n) {
    std::string text =
        "NRRD0004\ntype: int\ndimension: 3\nsizes: " + std::to_string(n) + " 1 1\nencoding: ascii\n\n";
    for (int v = 0; v < n; ++v) text += std::to_string((v * 7919) % n) + ' ';
    return text;
  };
  const TemporaryFolder folder;
  const LabelVolume atlas = read_label_volume(folder.write("atlas.nrrd", values(725)));
  REQUIRE(atlas.values.size() == 725);
  for (int v = 0; v < 725; ++v)
    REQUIRE(atlas.values[atlas.voxels[static_cast<std::size_t>(v)]] == (v * 7919) % 725);
  CHECK_THAT(problem_of(folder.write("scan.nrrd", values(70'000))), Contains("65535 different values"));
}
