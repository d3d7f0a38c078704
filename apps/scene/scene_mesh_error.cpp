#include "apps/scene/scene_mesh_error.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/scene/cache_folder.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/sha256.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t measuring_rule =
    4;                              // version of the measurement; a new number invalidates kept values
constexpr int lower_priority = 10;  // nice value of the thread

fs::path file_of(const Scene& scene, std::span<const Vec3> positions, const fs::path& folder) {
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(measuring_rule).add(solver_revision());
  for (const auto& [key, value] : scene.identity) hash.add(key + "=" + value + "\n");
  for (const Vec3& x : positions)
    for (const double c : x) hash.add(c);
  hash.add(scene.space.spacing);
  return folder / (hash.hex().substr(0, 32) + ".mesh-error.json");
}

Json to_file(const MeshError& e) {
  return {{"error", e.error},         {"low", number(e.low)},     {"high", number(e.high)},
          {"positions", e.positions}, {"method", name(e.method)}, {"finer", e.finer}};
}

std::optional<MeshError> mesh_error_in(const Json& kept) {
  try {
    MeshError e{.error = kept.at("error").get<double>(),
                .positions = kept.at("positions").get<std::size_t>()};
    e.finer = kept.at("finer").get<std::string>();
    const auto end = [&](const char* key) {
      return kept.at(key).is_null() ? unknown : kept.at(key).get<double>();
    };
    e.low = end("low"), e.high = end("high");
    for (const MeshErrorMethod method :
         {MeshErrorMethod::equilibria, MeshErrorMethod::rest, MeshErrorMethod::fine})
      if (kept.at("method") == name(method)) e.method = method;
    return e;
  } catch (const Json::exception&) {
    return {};
  }
}

std::string mesh_percent(double share) {
  return fmt::format("{:.{}g} %", 100 * share, share < 1 ? 2 : 3);
}

}  // namespace

std::vector<Vec3> mesh_error_positions(const Box& box, const Vec3& inward, double spacing) {
  const Vec3 n = inward.normalized(), t = n.unitOrthogonal(), s = n.cross(t);
  std::vector<Vec3> positions;
  for (const Vec3& direction : {n, t, s}) {
    double reach = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const double end = direction[i] > 0 ? box.high[i] : box.low[i];
      if (std::abs(direction[i]) > 1e-9) reach = std::min(reach, end / direction[i]);
    }
    positions.push_back((reach > 0 && std::isfinite(reach) ? 0.5 * reach : spacing) * direction);
  }
  return positions;
}

MeshError scene_mesh_error(const Scene& scene, const fs::path& folder, std::stop_token stop) {
  try {
    const std::vector<Vec3> positions =
        mesh_error_positions(scene.space.box, scene.inward, scene.space.spacing);
    const fs::path file = file_of(scene, positions, folder);
    if (const std::optional<Json> kept = read_kept(file))
      if (const std::optional<MeshError> known = mesh_error_in(*kept)) return *known;
    const MeshError found =
        mesh_error(scene.body, positions, {.spacing = scene.space.spacing, .stop = std::move(stop)});
    if (found.positions > 0) keep(file, to_file(found));
    return found;
  } catch (const std::exception& problem) {
    MeshError failed;
    failed.why = std::string("it failed: ") + problem.what();
    return failed;
  }
}

std::string measured_by(const MeshError& e) {
  if (e.positions == 0) return "not measured: " + e.why;
  const char* const what = e.method == MeshErrorMethod::rest   ? "displacements by the rest stiffness of"
                           : e.method == MeshErrorMethod::fine ? "positions by"
                                                               : "equilibria of";
  return fmt::format("{}{} {} {}", e.positions > 1 ? "largest at " : "", e.positions, what, e.finer);
}

std::string in_words(const MeshError& e) {
  if (e.positions == 0) return measured_by(e);
  const std::string interval =
      std::isfinite(e.high) ? fmt::format(", between {} and {}", mesh_percent(e.low), mesh_percent(e.high))
                            : "";
  return fmt::format("{}{} ({})", mesh_percent(e.error), interval, measured_by(e));
}

std::string discretisation_line(const MeshError& e, double shown) {
  return fmt::format("discretisation error of the mesh: {}{}", in_words(e),
                     e.error > shown ? ", more than the error shown" : "");
}

const JsonKeys<MeshError>& mesh_error_keys() {
  static const JsonKeys<MeshError> keys{
      {"discretisation_error", "1", "what the mesh itself gets wrong, relative; null: not measured",
       &MeshError::error},
      {"discretisation_interval", "1", "[low, high]: an interval that holds the true error; null: not known",
       [](const MeshError& e) {
         return json_numbers({e.low, e.high});
       }},
      {"discretisation_positions", "", "at which it was measured", &MeshError::positions},
      {"discretisation_by", "", "by what, or why not", measured_by}};
  return keys;
}

// ---- beside other work

MeshErrorTask::MeshErrorTask(const Scene& scene, When when) : scene_(scene), folder_(cache_folder()) {
  if (when != When::meanwhile || !scene.session.judging.discretisation_error || scene.touch.anywhere) return;
  found_ = std::async(std::launch::async, [this] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), lower_priority);  // of this thread
    return scene_mesh_error(scene_, folder_, stop_.get_token());
  });
}

MeshErrorTask::~MeshErrorTask() {
  stop_.request_stop();
}

MeshError MeshErrorTask::get() {
  if (!scene_.session.judging.discretisation_error) {
    MeshError none;
    none.why = "session.discretisation_error is false";
    return none;
  }
  if (scene_.touch.anywhere) {
    MeshError none;
    none.why =
        "the contact has no place of its own (forefeel solve SCENE --site=X,Y,Z --at=… "
        "--discretisation-error "
        "measures it at one)";
    return none;
  }
  if (!found_.valid())
    found_ = std::async(std::launch::async,
                        [this] { return scene_mesh_error(scene_, folder_, stop_.get_token()); });
  while (found_.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready)
    if (interrupt_flag().load()) stop_.request_stop();
  return found_.get();
}

}  // namespace forefeel
