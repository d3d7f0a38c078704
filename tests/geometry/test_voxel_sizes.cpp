// Sizes of voxels that a header states twice or with a sign: negative ones count as their absolute value, and where
// sform, qform and pixdim contradict each other, a warning says so. Ten variants of a seed: sizes, turns, byte order.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "geometry/segmentation/label_volume.hpp"
#include "tests/support/label_samples.hpp"
#include "tests/support/test.hpp"

namespace {

struct Nifti {
  Vec3 pixdim = Vec3::Ones();
  bool has_qform = false, has_sform = false;
  Mat3 sform = Mat3::Identity();  // columns: steps of the voxels
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  bool big_endian = false;

  // 348 bytes by their places in the standard, 4 of "no extension", then the voxels.
  std::string bytes(const LabelVolume& v) const {
    std::string text(352, '\0');
    const auto put = [&](std::size_t at, auto value) {
      std::memcpy(text.data() + at, &value, sizeof value);
      if (big_endian)
        std::reverse(text.begin() + static_cast<long>(at),
                     text.begin() + static_cast<long>(at + sizeof value));
    };
    put(0, std::int32_t{348});
    put(40, std::int16_t{3});
    for (std::size_t d = 0; d < 3; ++d) put(42 + 2 * d, static_cast<std::int16_t>(v.size[d]));
    put(70, std::int16_t{2}), put(72, std::int16_t{8}), put(76, 1.0f), put(108, 352.0f), put(112, 1.0f);
    for (int d = 0; d < 3; ++d) put(80 + 4 * static_cast<std::size_t>(d), static_cast<float>(pixdim[d]));
    text[123] = 2;  // mm
    put(252, std::int16_t(has_qform)), put(254, std::int16_t(has_sform));
    const double sign = turn.w() < 0 ? -1 : 1;
    put(256, static_cast<float>(sign * turn.x())), put(260, static_cast<float>(sign * turn.y()));
    put(264, static_cast<float>(sign * turn.z()));
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        put(280 + static_cast<std::size_t>(16 * r + 4 * c), static_cast<float>(sform(r, c)));
    text.replace(344, 3, "n+1");
    return text + test::label_bytes(v);
  }
};

Vec3 sizes(const LabelVolume& volume) {
  return 1e3 * volume.axes.colwise().norm().transpose();
}

bool warned(const LabelVolume& volume, const std::string& words) {
  return std::ranges::any_of(volume.warnings,
                             [&](const std::string& w) { return w.find(words) != std::string::npos; });
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE_THAT(text, Contains(from));
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("NIfTI: negative sizes, and forms that contradict each other") {
  const LabelVolume plain = test::nested_spheres({5, 4, 6}, {1, 2, 3}, 4, 2);
  const TemporaryFolder folder;
  std::mt19937 random(44);
  const auto real = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int variant = 0; variant < 10; ++variant) {
    const Vec3 size(real(0.3, 3), real(0.3, 3), real(0.3, 3));
    Nifti file{.pixdim = size, .big_endian = variant % 3 == 0};
    file.turn = Eigen::Quaterniond(real(0.2, 1), real(-1, 1), real(-1, 1), real(-1, 1)).normalized();
    const auto read = [&] { return read_label_volume(folder.write("a.nii", file.bytes(plain))); };
    const auto right = [&](const LabelVolume& volume) { return (sizes(volume) - size).norm() < 1e-5; };
    const Mat3 axes = file.turn.toRotationMatrix() * size.asDiagonal();
    INFO("variant " << variant);
    CHECK(right(read()));
    CHECK(read().warnings.empty());
    file.has_qform = true;
    CHECK((1e3 * read().axes - axes).norm() < 1e-5);
    CHECK(read().warnings.empty());
    // Negative sizes, with and without qform.
    const int negative = variant % 3;
    file.pixdim[negative] *= -1;
    if (variant > 5) file.pixdim[(negative + 1) % 3] *= -1;
    CHECK((1e3 * read().axes - axes).norm() < 1e-5);
    CHECK(warned(read(), fmt::format("pixdim[{}] is -", negative + 1)));
    file.has_qform = false;
    CHECK(right(read()));
    file.pixdim = size;
    file.pixdim[negative] = 0;
    for (const bool qform : {true, false}) {
      file.has_qform = qform;
      CHECK_THAT(error_of(read), Contains(fmt::format("pixdim[{}] is 0", negative + 1)));
    }
    file.pixdim = size;
    // sform agrees, then has other sizes, then directions alone, then another turn.
    file.has_sform = file.has_qform = true;
    file.sform = axes;
    CHECK((1e3 * read().axes - axes).norm() < 1e-5);
    CHECK(read().warnings.empty());
    file.sform.col(negative) *= real(1.05, 3);
    CHECK((1e3 * read().axes - file.sform).norm() < 1e-5);
    CHECK(warned(read(), "sform gives voxels of"));
    file.has_qform = variant % 2 == 0;
    file.sform = file.turn.toRotationMatrix();
    if (((size - Vec3::Ones()).array().abs() > 0.02).any())
      CHECK(warned(read(), "sform holds directions alone"));
    file.has_qform = true;
    file.sform = Eigen::AngleAxisd(real(0.1, 3), Vec3(1, 2, 3).normalized()).toRotationMatrix() * axes;
    CHECK(warned(read(), "turn the axes of the voxels differently"));
  }
}

TEST_CASE("negative sizes in MetaImage, NRRD and VTI; every format says where x, y and z point") {
  const LabelVolume plain = test::nested_spheres({5, 4, 6}, {1, 2, 3}, 4, 2);
  const TemporaryFolder folder;
  auto files = test::label_files(plain);
  const auto read = [&](const std::string& name, const std::string& from, const std::string& to) {
    return read_label_volume(folder.write(name, replaced(files[name], from, to)));
  };
  for (int negative = 0; negative < 3; ++negative) {
    const std::string a = negative == 0 ? "-1" : "1", b = negative == 1 ? "-2" : "2",
                      c = negative == 2 ? "-3" : "3";
    const std::string sized = a + " " + b + " " + c;
    const LabelVolume volumes[] = {
        read("b.mha", "ElementSpacing = 1 2 3", "ElementSpacing = " + sized),
        read("e.vti", "Spacing=\"1 2 3\"", "Spacing=\"" + sized + "\""),
        read("c.nrrd", "space directions: (1,0,0) (0,2,0) (0,0,3)", "spacings: " + sized)};
    for (const LabelVolume& volume : volumes) {
      CHECK((sizes(volume) - Vec3(1, 2, 3)).norm() < 1e-12);
      CHECK(volume.axes.determinant() > 0);
      CHECK(warned(volume, "is -"));
    }
  }
  CHECK(read_label_volume(folder.write("a.nii", files["a.nii"])).directions == "right, anterior, superior");
  CHECK_THAT(read("b.mha", "NDims", "NDims").directions, Catch::StartsWith("left, posterior, superior"));
  CHECK(read("c.nrrd", "space dimension: 3", "space: left-posterior-superior").directions ==
        "left, posterior, superior");
  CHECK(read("c.nrrd", "space dimension: 3", "space: RAS").directions == "right, anterior, superior");
  CHECK(read("c.nrrd", "space dimension: 3", "space dimension: 3").directions == "not named by the file");
}
