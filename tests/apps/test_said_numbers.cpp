// The numbers in sentences: each is computed again here from the tables that the same command writes, and the sentence
// must say it.

#include <fmt/format.h>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/halton.hpp"
#include "tests/apps/felt_in_table.hpp"
#include "tests/support/executable.hpp"

namespace {

using Row = std::size_t;

// A file of a command. Quantiles are of the finite values, by the textbook: the smallest value with at least that share
// of the values below it or equal to it.
struct Table {
  CsvText csv;
  Table(const Workshop& shop, const std::string& file) : csv(CsvText::read(shop.path() / file, "a table")) {}

  double at(Row row, std::string_view column) const { return csv.number(row, column); }
  bool is(Row row, std::string_view column) const { return at(row, column) == 1; }
  Vec3 vector(Row row, const std::array<const char*, 3>& columns) const {
    return {at(row, columns[0]), at(row, columns[1]), at(row, columns[2])};
  }
  template <class Choose>
  std::size_t count(Choose choose) const {
    std::size_t n = 0;
    for (Row row = 0; row < csv.rows(); ++row) n += choose(row) ? 1 : 0;
    return n;
  }
  template <class Choose>
  double share(Choose choose) const {
    return double(count(choose)) / double(csv.rows());
  }
  template <class Value>
  std::vector<double> sorted(Value value) const {
    std::vector<double> values;
    for (Row row = 0; row < csv.rows(); ++row)
      if (const double v = value(row); std::isfinite(v)) values.push_back(v);
    std::ranges::sort(values);
    return values;
  }
};

double rank(const std::vector<double>& sorted, double share) {
  REQUIRE_FALSE(sorted.empty());
  return sorted[std::size_t(std::max(1.0, std::ceil(share * double(sorted.size())))) - 1];
}
double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// As commands print them.
std::string percent(double share) {
  if (share == 0 || share == 1) return fmt::format("{:.0f} %", 100 * share);
  if (share < 1e-3) return "below 0.1 %";
  return share > 0.999 ? "above 99.9 %" : fmt::format("{:.1f} %", 100 * share);
}
std::string share_of(std::size_t part, std::size_t all) {
  return all < 20 ? fmt::format("{} of {}", part, all)
                  : fmt::format("{} of {}", percent(double(part) / double(all)), all);
}

using Said = std::vector<std::string>;
void check_said(const std::string& text, const Said& sentences) {
  for (const std::string& sentence : sentences) CHECK_THAT(text, Contains(sentence));
}

const std::array<const char*, 3> tip{"x", "y", "z"}, rendered{"rendered_x", "rendered_y", "rendered_z"},
    reference{"rx", "ry", "rz"};
constexpr double jnd_share = 0.07, jnd_floor = 0.01, h = 0.004;  // session.jnd_…; [1], [N], [m]

// frames.csv of a run.
struct Frames : Table {
  using Table::Table;
  double off(Row i) const { return (vector(i, rendered) - vector(i, reference)).norm(); }
  bool within(Row i) const { return off(i) <= std::max(jnd_share * vector(i, reference).norm(), jnd_floor); }
  bool judged(Row i, const char* column) const { return is(i, column) && std::isfinite(at(i, "error")); }
  bool labelled(Row i, const char* label) const { return csv.text(i, "label") == label; }
  bool outside(Row i) const { return vector(i, tip).cwiseAbs().maxCoeff() > h * (1 + 1e-6); }
};

// What a session says of its frames, on screen and in its report.
void check_session(const Workshop& shop, const std::string& out, double limit) {
  const Frames frames(shop, "run/frames.csv");
  const Table states(shop, "run/states.csv"), solves(shop, "run/dispatch.csv"),
      switches(shop, "run/switches.csv");
  const std::string report = shop.read("run/report.html");
  const auto n = frames.csv.rows();
  const auto all =
      frames.sorted([&](Row i) { return frames.judged(i, "sampled") ? frames.at(i, "error") : NAN; });
  const auto inside = [&](const char* column) {
    return frames.count([&](Row i) { return frames.judged(i, column) && frames.within(i); });
  };
  const auto visits = frames.count([&](Row i) { return frames.judged(i, "first_visit"); });
  const std::string samples_felt = share_of(inside("sampled"), all.size()),
                    visits_felt = share_of(inside("first_visit"), visits);
  const double clamped = frames.share([&](Row i) { return frames.vector(i, rendered).norm() > limit; }),
               outside = frames.share([&](Row i) { return frames.outside(i); });
  const auto in = [&](const char* label) {
    return percent(frames.share([&](Row i) { return frames.labelled(i, label); }));
  };
  const auto widths =
      frames.sorted([&](Row i) { return frames.judged(i, "sampled") ? frames.at(i, "bar95") : NAN; });
  const auto held = frames.count(
      [&](Row i) { return frames.judged(i, "sampled") && frames.off(i) <= frames.at(i, "bar95"); });
  const auto over =
      frames.count([&](Row i) { return frames.at(i, "switch_change") > frames.at(i, "switch_bound"); });
  const auto solved = solves.count([&](Row i) { return solves.csv.text(i, "status") == "solved"; });
  const auto used = solves.count([&](Row i) { return std::isfinite(solves.at(i, "first_used")); });
  const test::FeltInTable felt = test::felt_in(frames.csv);
  REQUIRE(felt.count > 0);
  REQUIRE(clamped > 0.05);
  REQUIRE(outside > 0.05);
  REQUIRE(visits > 0);
  CHECK(states.csv.rows() == solved);
  check_said(
      out,
      {fmt::format("attention: {:.3g} % of the frames were clamped at the force limit of {:.3g} N",
                   100 * clamped, limit),
       fmt::format("{} of the time was outside the box of states", percent(outside)),
       fmt::format("s rendered: {} frames (virtual clock), 0 missed deadlines; 0 states known at the "
                   "start, {} solved by ",
                   n, solved),
       fmt::format("), {} used", used),
       fmt::format("{:>12}  of the force, for 95 % of the samples (median {}); below what a hand feels: "
                   "{} samples, {} first visits",
                   percent(rank(all, 0.95)), percent(rank(all, 0.5)), samples_felt, visits_felt),
       fmt::format("{:>12}  of {} true forces lay inside the 95 % error bars, of half-width {:.2g} N "
                   "(median)",
                   percent(double(held) / double(widths.size())), widths.size(), rank(widths, 0.5)),
       fmt::format("{:>12}  of the time among densely known states; sparse {}, gap {}, blank {}; outside "
                   "the box {}",
                   in("safe"), in("sparse"), in("gap"), in("blank"), percent(outside)),
       fmt::format("of {} changes of model {} moved it by more", switches.csv.rows(), over),
       fmt::format("clamped {}", percent(clamped))});
  CHECK(test::felt_said(out) == felt.count);
  const auto tile = [](const std::string& value, const std::string& what) {
    return fmt::format("<b>{}</b><span>{}", value, what);
  };
  const auto largest = [&](const char* column) {
    return fmt::format("{:.4g} N", frames.sorted([&](Row i) { return frames.at(i, column); }).back());
  };
  check_said(report,
             {tile(samples_felt, "sampled frames within the just noticeable difference"),
              tile(visits_felt, "first visits within the just noticeable difference"),
              fmt::format("95th percentile of {} samples", all.size()),
              tile(std::to_string(over), fmt::format("of {} frames in which a switch exceeded", n)),
              tile(largest("switch_change"), fmt::format("largest change by one of {} switches in one frame; "
                                                         "{} undamped",
                                                         switches.csv.rows(), largest("undamped_jump"))),
              tile(percent(outside), fmt::format("of {} frames outside the box", n)),
              tile(std::to_string(solved), fmt::format("states solved; {} used by a model", used)),
              fmt::format("<h2>Error by label ({} samples)</h2>", all.size())});
  std::size_t rows = 0;
  for (const char* label : {"safe", "sparse", "gap", "blank"}) {
    const auto of = frames.sorted([&](Row i) {
      return frames.judged(i, "sampled") && frames.labelled(i, label) ? frames.at(i, "error") : NAN;
    });
    if (of.empty()) continue;
    ++rows;
    const auto cell = [](double share) { return percent(share); };
    check_said(report,
               {fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}"
                            "</td><td class=\"n\">{}</td>",
                            label, of.size(), cell(rank(of, 0.5)), cell(rank(of, 0.95)), cell(of.back()))});
  }
  CHECK(rows > 1);
}

}  // namespace

TEST_CASE("a session says the numbers of its tables, and so do its report and its replay") {
  const BeamShop shop("[session.limits]\nforce = 0.05\n");
  // Few workers and slow solves: errors above the JND, all sorts of places, and frames outside the box.
  const auto run = shop.run(
      "session beam.toml --clock virtual --seconds 1.5 --workers 2 --cost constant:0.15 --set "
      "session.discretisation_error=false --set session.rest_first=false --set session.first_guess=false "
      "--device path:lissajous,speed=0.06,amplitude=0.012 -o run");
  check_session(shop, run.out, 0.05);
  const auto again = shop.run("replay run");
  const Frames frames(shop, "run/frames.csv");
  const auto n = frames.csv.rows();
  check_said(again.out, {fmt::format("{} of {} frames equal: {:.3f} s, {} states", n, n,
                                     frames.at(n - 1, "t"), Table(shop, "run/states.csv").csv.rows()),
                         fmt::format("in {} rows of frames.csv", n)});
}

TEST_CASE("under the real clock pauses, skipped frames and missed deadlines are those of frames.csv") {
  const BeamShop shop;
  const auto run = shop.run(
      "session beam.toml --clock real --seconds 0.4 --workers 1 --set session.discretisation_error=false "
      "--device path:circle,speed=0.03 -o run --json");
  const json loop = run.json()["loop"];
  const Frames frames(shop, "run/frames.csv");
  const auto n = frames.csv.rows();
  double longest = frames.at(0, "t") + 1e-6 * frames.at(0, "lateness_us");  // since the start
  const auto began = [&](Row i) { return frames.at(i, "t") + 1e-6 * frames.at(i, "lateness_us"); };
  for (Row i = 1; i < n; ++i) longest = std::max(longest, began(i) - began(i - 1));
  const auto skipped = std::size_t(std::lround(1000 * frames.at(n - 1, "t"))) + 1 - n;
  const auto late =
      frames.count([&](Row i) { return frames.at(i, "cost_us") + frames.at(i, "lateness_us") > 1000; });
  CHECK(loop["longest_pause"].get<double>() == Approx(longest).margin(2e-6));
  CHECK(loop["skipped"] == skipped);
  CHECK(run.json()["deadline"]["missed"] == late + skipped);
  const auto cost = frames.sorted([&](Row i) { return frames.at(i, "cost_us"); });
  check_said(shop.read("run/report.html"),
             {fmt::format(
                 "<b>{}</b><span>deadlines missed of {} frames; a frame costs {:.4g} µs (median; p99 {:.4g} "
                 "µs)",
                 late + skipped, n, rank(cost, 0.5), rank(cost, 0.99))});
  if (skipped > 0)
    CHECK_THAT(run.json()["notes"].dump(), Contains(fmt::format("the longest pause was {:.3g} s", longest)));
}

TEST_CASE("classify says the volumes and parts of its regions, and counts of its points") {
  const BeamShop shop;
  // Three lattice planes with a hole, and two states apart from them.
  std::string rows = "x,y,z,fx,fy,fz\n";
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -1; k <= 1; ++k)
        if (std::abs(i) + std::abs(j) > 0)
          rows += fmt::format("{},{},{},{},{},{}\n", i * h, j * h, k * h, -4 * i * h, -4 * j * h, -9 * k * h);
  rows += "0.03,0,0,-0.1,0,0\n0.034,0.01,0,-0.12,-0.03,0\n";
  shop.write("s.csv", rows);
  const auto regions = shop.run("classify s.csv --spacing 0.004 -o regions.csv");
  const Table leaves(shop, "regions.csv");
  const auto volume = [&](Row i) { return leaves.at(i, "dx") * leaves.at(i, "dy") * leaves.at(i, "dz"); };
  double all = 0;
  std::map<std::string, std::pair<double, std::set<double>>> by_label;
  for (Row i = 0; i < leaves.csv.rows(); ++i) {
    auto& [sum, parts] = by_label[std::string(leaves.csv.text(i, "label"))];
    sum += volume(i), all += volume(i), parts.insert(leaves.at(i, "component"));
  }
  CHECK(by_label.size() >= 3);
  for (const auto& [label, found] : by_label)
    check_said(regions.out, {fmt::format("{:<7}{:>12.5g} cm3 {:>6.1f} %  {} component{}\n", label,
                                         1e6 * found.first, 100 * found.first / all, found.second.size(),
                                         found.second.size() == 1 ? "" : "s")});
  const auto points = shop.run("classify s.csv --spacing 0.004 --grid 0.004 -o labels.csv");
  const Table labels(shop, "labels.csv");
  const auto count = [&](const char* label) {
    return labels.count([&](Row i) { return labels.csv.text(i, "label") == label; });
  };
  check_said(points.out, {fmt::format("{} points: safe {}, sparse {}, gap {}, blank {}", labels.csv.rows(),
                                      count("safe"), count("sparse"), count("gap"), count("blank"))});
}

namespace {

// The numbers of one array of an ASCII .vtu.
std::vector<double> array_of(const std::string& vtu, const std::string& name) {
  const std::size_t at = vtu.find("Name=\"" + name + "\"");
  REQUIRE(at != std::string::npos);
  std::istringstream text(vtu.substr(vtu.find('>', at) + 1));
  std::vector<double> values;
  for (std::string word; text >> word && !word.starts_with('<');) values.push_back(std::stod(word));
  return values;
}

}  // namespace

TEST_CASE("bars hold the shares of the forces left out that classify writes, also in evaluate") {
  const BeamShop shop;
  const std::string wide = "--set 'state_space.box=[[-0.008,-0.008,-0.008],[0.008,0.008,0.008]]' ";
  const auto made = shop.run("generate beam.toml " + wide + "-o s.states");
  shop.run("export s.states -o s.csv --quiet");
  const Table states(shop, "s.csv");
  check_said(made.out, {fmt::format("s.states: {0} states, {0} solved in", states.csv.rows())});
  // With a part of them left out, some places are known better than others.
  std::istringstream lines(shop.read("s.csv"));
  std::string line, part;
  for (Row row = 0; std::getline(lines, line); ++row) {
    const Vec3 x = row > 0 ? states.vector(row - 1, tip) : Vec3(Vec3::Zero());
    if (x[0] <= 0 || std::abs(x[1] * x[2]) > 63e-6 || row % 5 == 0) part += line + '\n';
  }
  shop.write("part.csv", part);
  const auto told = shop.run("classify part.csv --spacing 0.004 --bars --tolerance '0.0001 N' -o map.vtu");
  const std::string left = shop.read("map_left_out.vtu");
  const auto errors = array_of(left, "error");
  std::array<std::string, 3> inside;
  for (std::size_t level = 0; level < 3; ++level) {
    const auto bars = array_of(left, "bar" + std::to_string(std::array{90, 95, 99}[level]));
    std::size_t known = 0, held = 0;
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (std::isfinite(bars[i])) ++known, held += errors[i] <= bars[i];
    inside[level] = known > 0 ? fmt::format("{:.1f}", 100.0 * double(held) / double(known)) : "?";
  }
  auto widths = array_of(left, "bar95");
  std::ranges::sort(widths);
  const std::string sentence = fmt::format(
      "error bars of 90/95/99 %: {}/{}/{} % of {} comparisons with known forces, left out in groups, lie "
      "inside; "
      "median half-width of 95 % {:.3g} N",
      inside[0], inside[1], inside[2], errors.size(), widths[widths.size() / 2]);
  check_said(told.out, {sentence});
  // Evaluate at the places that classify looks at, with the bars of each in its table.
  const Box box{Vec3::Constant(-0.008), Vec3::Constant(0.008)};
  std::string points = "x,y,z\n";
  for (const Vec3& x : halton_points(box, 300)) points += fmt::format("{},{},{}\n", x[0], x[1], x[2]);
  shop.write("q.csv", points);
  const auto evaluated = shop.run("evaluate part.csv --spacing 0.004 --points q.csv -o f.csv");
  check_said(evaluated.out,
             {sentence, fmt::format("300 points from {} states: rbf", std::ranges::count(part, '\n') - 1)});
  const Table forces(shop, "f.csv");
  std::vector<double> asked;
  for (Row i = 0; i < forces.csv.rows(); ++i)
    if (const double bar = forces.at(i, "bar95"); std::isfinite(bar)) asked.push_back(bar);
  std::ranges::sort(asked);
  check_said(evaluated.out,
             {fmt::format("; at {} points asked for {:.3g} N", asked.size(), asked[asked.size() / 2])});
  const double known = forces.share([&](Row i) { return forces.at(i, "bar95") <= 1e-4; });
  const auto called = std::ranges::count_if(array_of(left, "bar95"), [](double w) { return w <= 1e-4; });
  const auto bars = array_of(left, "bar95");
  std::size_t true_ones = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) true_ones += bars[i] <= 1e-4 && errors[i] <= 1e-4;
  REQUIRE(called > 0);
  CHECK(known < 1);
  CHECK(known > 0);
  check_said(told.out,
             {fmt::format("known within 0.0001 N: {:.1f} % of 300 places of the box; of {} forces left out "
                          "that count as known so, {:.1f} % are",
                          100 * known, called, 100.0 * double(true_ones) / double(called))});
}

TEST_CASE("a study says the means, the difference and the interval of its cells") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.6\nrest_first = false\nfirst_guess = false\n"
                                      "discretisation_error = false\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\ncost = [\"constant:0.02\", \"constant:0.3\"]\n"
             "device = [\"path:circle,speed=0.03\", \"path:reach,speed=0.05\", \"path:line,speed=0.02\", "
             "\"path:lissajous,speed=0.04\"]\n");
  const auto run = shop.run("study study.toml -o out");
  const Table cells(shop, "out/cells.csv");
  const char* const metric = "error.first_visit.within_jnd";
  const std::vector<std::string> devices{"path:circle,speed=0.03", "path:reach,speed=0.05",
                                         "path:line,speed=0.02", "path:lissajous,speed=0.04"};
  const auto mean_of = [&](const std::string& column, const std::string& device,
                           const std::string& cost = "") {
    return mean(cells.sorted([&](Row i) {
      const bool mine =
          cells.csv.text(i, "device") == device && (cost.empty() || cells.csv.text(i, "cost") == cost);
      return mine ? cells.at(i, column) : NAN;
    }));
  };
  std::vector<double> fast, slow, difference;
  for (const std::string& device : devices) {
    fast.push_back(mean_of(metric, device, "constant:0.02"));
    slow.push_back(mean_of(metric, device, "constant:0.3"));
    difference.push_back(fast.back() - slow.back());
    double visits = 0, felt = 0;
    for (Row i = 0; i < cells.csv.rows(); ++i)
      if (cells.csv.text(i, "device") == device) {
        const double of = cells.at(i, "error.first_visit.samples");
        visits += of, felt += of * cells.at(i, metric);
      }
    const auto share = [&](const char* column) {
      return fmt::format("{:.3g} %", 100 * mean_of(column, device));
    };
    check_said(run.out, {fmt::format("{} | endless | 0.6 s | 4 | {} | {} | {} | {} | {}", device,
                                     share_of(std::size_t(std::lround(felt)), std::size_t(visits)),
                                     share("safety.clamped_share"), share("safety.slewed_share"),
                                     share("time_outside"), share("solver.busy_share"))});
  }
  const double shift = mean(difference);
  double squares = 0;
  for (const double d : difference) squares += (d - shift) * (d - shift);
  const double half =
      3.182446305284263 * std::sqrt(squares / 3 / 4);  // t of 97.5 % with 3 degrees of freedom
  REQUIRE(shift > 0);
  REQUIRE(half > 0);
  const auto points = [](double value) { return fmt::format("{:.3g}", 100 * value); };
  check_said(run.out, {fmt::format(": constant:0.02 {} %, constant:0.3 {} % of first visits within the JND",
                                   points(mean(fast)), points(mean(slow))),
                       fmt::format("{} points, 95 % interval {} to {}, over 8 pairs on 4 motions",
                                   points(shift), points(shift - half), points(shift + half)),
                       fmt::format("constant:0.3 against constant:0.02: {}, bootstrap", points(-shift)),
                       fmt::format("Student's [{}, {}]", points(-shift - half), points(-shift + half))});
  const std::string report = shop.read("out/report.html");
  // Every measure by cost: the mean over all cells of each value.
  const auto measure = [&](const char* title, const char* column, double scale) {
    std::string row = fmt::format("<tr><td>{}</td>", title);
    for (const char* cost : {"constant:0.02", "constant:0.3"})
      row += fmt::format("<td class=\"n\">{:.3g}</td>",
                         scale * mean(cells.sorted([&](Row i) {
                           return cells.csv.text(i, "cost") == cost ? cells.at(i, column) : NAN;
                         })));
    check_said(report, {row});
  };
  measure("first visits within the JND [%]", metric, 100);
  measure("error, p95 [%]", "error.p95", 100);
  measure("time in safe [%]", "time_in.safe", 100);
  measure("load (needed over solved states per second)", "load", 1);
}
