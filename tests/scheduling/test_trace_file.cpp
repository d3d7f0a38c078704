// Recorded motions in file formats that occur in practice.

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace_check.hpp"
#include "scheduling/motion/trace_file.hpp"
#include "tests/support/test.hpp"

namespace {

TraceRows read(const std::string& text, const TraceFormat& format,
               MissingPositions missing = MissingPositions::leave_out) {
  const TemporaryFolder folder;
  std::ofstream(folder / "m.txt") << text;
  return read_trace_rows(folder / "m.txt", format, missing);
}

std::string refusal(const std::string& text, const TraceFormat& format) {
  return error_of([&] { read(text, format); });
}

void check_rows(const TraceRows& rows) {  // 0, 0.5, 1 s at (1, 2, 3), (1.5, 2, 3), (2, 2, 3) mm
  REQUIRE(rows.times.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(std::abs(rows.times[i] - 0.5 * double(i)) < 1e-12);
    CHECK((rows.positions[i] - 1e-3 * Vec3(1 + 0.5 * double(i), 2, 3)).norm() < 1e-15);
  }
}

TraceFormat with(std::vector<std::string> columns, const std::string& unit, double rate = 0,
                 std::string tool = {}) {
  TraceFormat format{.columns = std::move(columns), .rate = rate, .tool = std::move(tool)};
  if (!unit.empty()) REQUIRE(parse_trace_unit(unit, format));
  return format;
}

}  // namespace

TEST_CASE("one motion in many forms is the same motion") {
  SECTION("the usual one") {
    check_rows(read("t,x,y,z\n7,0.001,0.002,0.003\n7.5,0.0015,0.002,0.003\n8,0.002,0.002,0.003\n", {}));
  }
  SECTION("white space and numbers of columns, without a header") {
    check_rows(read("a 3 2 1  0\na 3 2 1.5  500\na 3 2 2  1000\n", with({"5", "4", "3", "2"}, "mm/ms")));
  }
  SECTION("names in another order, a row of units, an orientation") {
    const TraceRows rows =
        read("# log of 3 May\ntime;qw;pz;py;px\nms;;mm;mm;mm\n0;1;3;2;1\n500;1;3;2;1,5\n1000;1;3;2;2\n",
             with({"time", "px", "py", "pz"}, "mm/ms"));
    check_rows(rows);
    CHECK(rows.ignored == 1);
    CHECK(rows.orientation);
  }
  SECTION("a rate instead of times") {
    check_rows(read("x\ty\tz\n1\t2\t3\n1.5\t2\t3\n2\t2\t3\n", with({}, "mm", 2)));
  }
  SECTION("one of two tools, by a column of names") {
    check_rows(
        read("t,tool,x,y,z\n0,pen,1,2,3\n0,cup,9,9,9\n500,pen,1.5,2,3\n500,cup,9,9,9\n1000,pen,2,2,3\n",
             with({}, "mm/ms", 0, "pen")));
  }
  SECTION("one of two tools that have columns of their own") {
    check_rows(
        read("t,left_x,left_y,left_z,right_x,right_y,right_z\n0,9,9,9,1,2,3\n500,9,9,9,1.5,2,3\n1000,9,9,9,2,"
             "2,3\n",
             with({}, "mm/ms", 0, "right")));
  }
  SECTION("without a header, under a comment in prose") {
    check_rows(
        read("# thanks to many people, 2014, see the page\n7 0.001 0.002 0.003\n7.5 0.0015 0.002 0.003\n8 "
             "0.002 0.002 0.003\n",
             {}));
  }
  SECTION("samples that the tracker lost are left out and counted") {
    const TraceRows rows = read(
        "t,x,y,z\n0,0,0,0\n0,0.4,.3,1\n100,0,0,0\n200,0,0,0\n500,.4005,.3,1\n1000,.401,.3,1\n1200,0,0,0\n",
        with({}, "m/ms"));
    CHECK(rows.lost == 4);
    REQUIRE(rows.times.size() == 3);
    CHECK(rows.times[2] == 1);
    CHECK(rows.positions[0] == Vec3(0.4, 0.3, 1));
    CHECK(trace_notes(rows).size() == 1);
  }
  SECTION("a motion that begins at rest, or passes through it, has lost nothing") {
    const TraceRows rows = read("t,x,y,z\n0,0,0,0\n1,0,0,-.001\n2,0,0,0\n3,0,.005,0\n", with({}, "m/s"));
    CHECK(rows.lost == 0);
    CHECK(rows.times.size() == 4);
    CHECK(read("t,x,y,z\n0,0,0,0\n1,0,0,0\n", with({}, "m/s")).lost == 0);
  }
  SECTION("a coordinate that the file does not have is zero") {
    const TraceRows rows = read("0 1 2\n500 1.5 2\n", with({"1", "2", "3", "-"}, "mm/ms"));
    REQUIRE(rows.positions.size() == 2);
    CHECK((rows.positions[1] - Vec3(0.0015, 0.002, 0)).norm() < 1e-15);
    CHECK(read("ms,a,b\n0,1,2\n", with({"ms", "-", "b", "a"}, "mm")).positions[0] == Vec3(0, 0.002, 0.001));
  }
  SECTION("rows without a position keep their time, and are counted") {
    const TraceRows rows =
        read("t,x,y,z\n0,1,2,3\n250,,,\n500,1.5,2,3\n750,nan,nan,nan\n1000,2,2,3\n", with({}, "mm/ms"));
    check_rows(rows);
    CHECK(rows.missing == 2);
    const TraceRows by_rate = read("x,y,z\n1,2,3\n,,\n1.5,2,3\n,,\n2,2,3\n", with({}, "mm", 4));
    check_rows(by_rate);
  }
}

TEST_CASE("a file read by numbers names its columns by its header, not by a row of data") {
  const std::string text =
      "Tools,Name,Frame,State,Tx,Ty,Tz\n2,a,,MISSING,,,\n2,b,,MISSING,,,\n"
      "2,a,1,OK,1,2,3\n2,b,1,OK,9,9,9\n2,a,2,OK,1,2,3\n2,b,2,OK,9,9,9\n2,a,3,OK,1,2,3\n2,b,3,OK,9,9,9\n";
  CHECK_THAT(refusal(text, with({"3", "5", "6", "7"}, "mm")),
             Contains("several tools (Name), expected tool=NAME with one of a, b"));
}

TEST_CASE("what is not clear in a recorded motion is refused in words") {
  const std::string tools = "t,id,x,y,z\n0,a,1,2,3\n0,b,9,9,9\n1,a,1,2,3\n1,b,9,9,9\n";
  CHECK_THAT(refusal(tools, with({}, "mm")),
             Contains("several tools (id), expected tool=NAME with one of a, b"));
  CHECK_THAT(refusal(tools, with({}, "mm", 0, "c")), Contains("no tool 'c'", "a, b"));
  CHECK_THAT(refusal("time,px,py,pz\n0,1,2,3\n", with({}, "mm")),
             Contains("m.txt:1", "no column 't'", "time, px, py, pz", "numbers from 1"));
  CHECK_THAT(refusal("0 1 2 3\n", with({"0", "1", "2", "3"}, "")), Contains("no column 0"));
  CHECK_THAT(refusal("0 1 2 3\n", with({"1", "2", "3", "5"}, "")), Contains("from 1 to 4"));
  CHECK_THAT(refusal("t,x,y,z\n0,1,2,3\nnoon,1,2,3\n", with({}, "mm")),
             Contains("m.txt:3: the time is 'noon'"));
  CHECK_THAT(refusal("t,x,y,z\n2021-12-31T23:59:59.5Z,1,2,3\n2022-01-01T00:00:00Z,1.5,2,3\n", with({}, "mm")),
             Contains("no row has a number", "'2021-12-31T23:59:59.5Z'"));
  CHECK_THAT(refusal("t,x,y,z\n0,1,2,3\n1,far,2,3\n", with({}, "mm")),
             Contains("m.txt:3: the position is 'far'"));
  CHECK_THAT(refusal("t,x,y,z\n0,a,b,c\n", with({}, "mm")), Contains("no row has a number"));
  CHECK_THAT(refusal("t,x,y,z\n0,a,b,c\n", with({"t", "x", "y", "z"}, "mm")),
             Contains("columns t, x, y, z, which hold '0', 'a', 'b', 'c' here"));
  // Numbers in a line of metadata do not make its file one without a header.
  CHECK_THAT(
      refusal("Version,1.23,Rate,360,Length,5,Frames,9\nFrame,Time,X,Y,Z\n0,0,1,2,3\n1,.1,1,2,3\n", {}),
      Contains("m.txt:2", "no column 't'", "Frame, Time, X, Y, Z"));
  CHECK_THAT(refusal("t,x,y,z,x,y,z\n0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n", with({}, "mm")),
             Contains("2 columns are called 'x', expected their numbers"));
  CHECK_THAT(refusal(std::string("PK\0\3 1 2 3", 11), {}), Contains("is no text"));
  const std::string matrices = "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n1 0 0 5.5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n";
  CHECK_THAT(refusal(matrices, with({"4", "3", "2"}, "mm", 100)), Contains("m.txt:1", "4 x 4 matrix"));
  TraceFormat format;
  for (const char* unit : {"", "inch", "mm/mm", "ms/s", "mm/"}) CHECK_FALSE(parse_trace_unit(unit, format));
}

TEST_CASE("a motion is checked, shifted, cut and resampled") {
  // 1 s at 10 mm/s along x, then 3 s of rest, then a step of 0.5 s without rows; 100 Hz.
  TraceRows rows;
  const auto add = [&](double t, double x) {
    rows.times.push_back(t);
    rows.positions.emplace_back(x, 0.004, 0);
    rows.lines.push_back(rows.lines.size() + 1);
  };
  for (int i = 0; i <= 400; ++i) add(0.01 * i, 0.01 * std::min(0.01 * i, 1.0));
  add(4.5, 0.012);
  add(4.5, 0.5);   // a second row at this time
  add(4.4, -0.5);  // goes back
  const TraceCheck check = check_trace(rows, Box{Vec3(-0.01, -0.01, -0.01), Vec3(0.005, 0.01, 0.01)});
  CHECK(check.rows == 404);
  CHECK(check.seconds == 4.5);
  CHECK(check.times.rate == Approx(100));
  CHECK(check.times.repeated == 1);
  CHECK(check.times.backward == 1);
  CHECK(check.times.gaps == 1);
  CHECK(check.times.longest_gap == Approx(0.5));
  CHECK(check.speed.p50 == Approx(0).margin(1e-12));
  CHECK(check.speed.p95 == Approx(0.01));
  CHECK(check.speed.max == Approx(0.01));
  CHECK(check.start == Approx(0.004));
  CHECK(check.starts_pressed_in());
  CHECK(check.rests.count == 1);
  CHECK(check.rests.longest == Approx(3).margin(0.011));  // 0.1 mm before the end of the stroke belong to it
  CHECK(check.rests.longest_from == Approx(1).margin(0.011));
  CHECK(*check.outside_from == Approx(0.51).margin(0.011));
  CHECK(*check.outside == Approx(351.0 / 402).margin(0.01));
  const std::vector<std::string> lines = trace_warnings(check);
  REQUIRE(lines.size() == 4);
  CHECK_THAT(lines[2], Contains("1 gaps in time, the longest 0.5 s"));

  const TraceRows grown = growing(rows);
  CHECK(grown.times.size() == 402);
  const TraceRows part = window(grown, 0.2, 0.8);
  CHECK(part.times.front() == 0);
  CHECK(part.times.back() == Approx(0.6));
  CHECK(part.positions.front().x() == Approx(0.002));
  CHECK_THROWS_AS(window(grown, 4.1, 4.2), InputError);
  const TraceRows fine = resampled(part, 1000);
  CHECK(fine.times.size() == 601);
  CHECK((fine.positions[300] - Vec3(0.005, 0.004, 0)).norm() < 1e-12);
}

TEST_CASE("the device of a recorded motion reads its form, and refuses times that do not grow") {
  const TemporaryFolder folder;
  std::ofstream(folder / "m.txt") << "frame ms X Y Z\n1 0 0 0 0\n2 10 1 0 0\n3 20 2 0 0\n4 20 3 0 0\n";
  FactoryContext where;
  where.folder = folder.path();
  TraceMotion motion{.file = "m.txt", .format = with({"ms", "X", "Y", "Z"}, "mm/ms")};
  CHECK_THAT(error_of([&] { make_device(motion, where); }), Contains("m.txt:5", "a second row at"));
  motion.format = with({"frame", "X", "Y", "Z"}, "mm/ms");
  const auto device = make_device(motion, where);
  CHECK(device->duration() == Approx(0.003));
  CHECK((device->position(0.002, Vec3::Zero()) - Vec3(0.002, 0, 0)).norm() < 1e-12);
  CHECK(to_text(DeviceSpec(motion)) == "trace:m.txt,columns=frame/X/Y/Z,unit=mm/ms");
}
