#include "apps/scene/scene_fine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "geometry/common/sha256.hpp"
#include "solver/body/body_digest.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/jet/rest_jet.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path file_of(const Body& body, const fs::path& folder) {
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(std::string_view("rest jet")).add(solver_revision());
  for (const auto& [key, value] : identity_of(body)) hash.add(key + "=" + value + "\n");
  return folder / (hash.hex().substr(0, 32) + ".jet.json");
}

std::optional<RestJet> rest_jet_in(const Json& kept) {
  try {
    RestJet rest;
    rest.jet.order = most_jet_order;
    const auto stiffness = kept.at("stiffness").get<std::array<double, 9>>();
    for (int i = 0; i < 9; ++i) rest.stiffness(i / 3, i % 3) = stiffness[static_cast<std::size_t>(i)];
    for (std::size_t i = 0; i < jet_size; ++i)
      rest.jet.coefficients[i] = kept.at("jet").at(jet_names()[i]).get<double>();
    return rest;
  } catch (const Json::exception&) {
    return {};
  }
}

Json to_file(const RestJet& rest, double seconds) {
  Json file{{"stiffness", Json::array()}, {"jet", Json::object()}, {"seconds", seconds}};
  for (int i = 0; i < 9; ++i) file["stiffness"].push_back(rest.stiffness(i / 3, i % 3));
  for (std::size_t i = 0; i < jet_size; ++i) file["jet"][jet_names()[i]] = rest.jet.coefficients[i];
  return file;
}

struct TimedJet {
  RestJet jet;
  double seconds = 0;  // that it took when it was made; 0: not known
};

// about: the seconds that it will take, or 0.
TimedJet kept_rest_jet(const Body& body, const InputPlace& where, Progress& progress, double about = 0) {
  constexpr double worth_saying = 10;  // [s]
  const fs::path file = file_of(body, cache_folder());
  if (const std::optional<Json> kept = read_kept(file))
    if (const std::optional<RestJet> rest = rest_jet_in(*kept)) return {*rest, kept->value("seconds", 0.0)};
  const std::string what = fmt::format("{} {} elements", body.mesh.tets.size(), name(body.element));
  progress.show(what);
  if (about >= worth_saying)
    progress.note(
        fmt::format("The fine body of {} takes about {}, once: it is kept. Quicker: fewer "
                    "body.fine.elements, or --set body.fine=false",
                    what, rough_time(about)));
  const auto start = std::chrono::steady_clock::now();
  const RestJet rest = rest_jet(body, where);
  const double seconds = seconds_since(start);
  keep(file, to_file(rest, seconds));
  return {rest, seconds};
}

// Of a jet at rest of `body`, from another body's: a factor of n nodes takes n^2, its jet n.
double about_seconds(const Body& body, const Body& other, double of_other) {
  const auto nodes = [](const Body& of) {
    return (of.element == Element::quadratic ? 1.5 : 0.25) * static_cast<double>(of.mesh.tets.size());
  };
  return of_other * std::pow(nodes(body) / nodes(other), 1.5);
}

// Eight times the elements, as far as a desktop makes and factors them within half a minute, twice at least. Where a
// subdivision would be larger, the level before shows the error too, with a wider interval.
std::size_t finer_elements(std::size_t fine, bool subdivided) {
  constexpr std::size_t affordable = 28'000;  // 12 s of one core, 1.8 GB
  if (subdivided) return 8 * fine <= affordable ? 8 * fine : std::max<std::size_t>(1, fine / 8);
  return std::max(2 * fine, std::min(8 * fine, affordable));
}

// What fails leaves the error unknown.
std::optional<Refinement> refine(const FineBodies& fine, const InputPlace& where, const Globals& globals) {
  constexpr std::size_t solved_elements = 1'800;  // 0.1 s a state
  try {
    Progress progress(globals, "Finer body");
    const std::size_t elements = fine.first.mesh.tets.size();
    Refinement made;
    auto solved =
        std::make_shared<Body>(elements <= 1.5 * solved_elements ? fine.first : fine.make(solved_elements));
    made.of_solved = kept_rest_jet(*solved, where, progress).jet;
    made.solved = std::move(solved);
    const Body finer = fine.make(finer_elements(elements, fine.subdivided));
    made.ratio = std::cbrt(static_cast<double>(finer.mesh.tets.size()) / static_cast<double>(elements));
    if (made.ratio == 1) return {};
    made.finer = kept_rest_jet(finer, where, progress).jet;
    return made;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

std::shared_ptr<const FineJet> fine_jet_of(const Body& body, FineBodies fine, const InputPlace& where,
                                           bool quiet) {
  Globals globals;
  globals.quiet = quiet;
  Progress progress(globals, "Fine body");
  const TimedJet of_body = kept_rest_jet(body, where, progress);
  const RestJet of_fine =
      kept_rest_jet(fine.first, where, progress, about_seconds(fine.first, body, of_body.seconds)).jet;
  std::string words = fine_body_in_words(fine.first);
  return std::make_shared<const FineJet>(
      of_fine, of_body.jet, std::move(words),
      [fine = std::move(fine), where, globals] { return refine(fine, where, globals); });
}

Body refined_to(const Body& body, std::size_t elements) {
  Body fine = body;
  // the level nearest in ratio
  while (std::sqrt(8.0) * static_cast<double>(fine.mesh.tets.size()) < static_cast<double>(elements))
    fine = refined(fine);
  return fine;
}

}  // namespace forefeel
