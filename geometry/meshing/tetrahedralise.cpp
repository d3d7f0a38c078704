#include "geometry/meshing/tetrahedralise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <set>
#include <type_traits>

#include "geometry/common/error.hpp"
#include "geometry/meshing/child_process.hpp"
#include "geometry/meshing/graded_fill.hpp"
#include "geometry/meshing/surface_process.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

constexpr double share = 0.05;         // accepted relative deviation of the count
constexpr double close_enough = 0.02;  // deviation at which the search stops

bool is_graded(const TetrahedraliseOptions& options) {
  return options.toward || options.rim || !options.marks.empty() || !options.pins.empty();
}

// Of a repaired surface. Without a contact all edges are wanted alike.
SizeField size_field_of(const Surface& closed, const TetrahedraliseOptions& options) {
  if (!options.toward) {
    const double edge = uniform_edge(closed, options.elements);
    return {.near = edge, .far = edge};
  }
  Toward toward = *options.toward;
  if (!(toward.radius > 0) || !std::isfinite(toward.radius))
    throw InputError(options.name,
                     fmt::format("radius of the contact {} m, expected a positive number", toward.radius));
  toward.site = nearest_point(closed, toward.site);
  return size_field(closed, toward, options.elements);
}

void scale(Surface& surface, double length, const std::string& name) {
  const double side = bounding_box(surface).size().maxCoeff();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError(name, fmt::format("length {} m, expected a positive number", length));
  if (!(side > 0)) throw InputError(name, "has no extent, expected a closed surface");
  for (Vec3& node : surface.nodes) node *= length / side;
}

// Coarse triangles cut off round ends; this scales the mesh back to the wanted length.
void match_length(TetMesh& mesh, double length, const Vec3& centre) {
  const double factor = length / longest_side(mesh);
  for (Vec3& node : mesh.nodes) node = centre + factor * (node - centre);
}

// Edge l of the tetrahedra if `elements` of about equal size fill the body. The mean volume of TetGen's tetrahedra is
// 0.15 l^3 (a regular one has 0.118 l^3).
double edge_for(const Surface& surface, std::size_t elements) {
  return std::cbrt(enclosed_volume(surface) / (0.15 * static_cast<double>(elements)));
}

bool meets(const std::optional<TetMesh>& mesh, std::size_t elements) {
  return mesh &&
         std::abs(static_cast<double>(mesh->tets.size()) / static_cast<double>(elements) - 1) <= share;
}

// One try may take at most half of the time, so that a second try is possible.
std::chrono::milliseconds patience_of(const TetrahedraliseOptions& options) {
  const double limit = options.time_limit.value_or(default_time_limit(options.elements));
  return std::chrono::milliseconds(static_cast<std::int64_t>(500 * limit));
}

// Progress of the child process, in memory shared with the parent.
struct Told {
  std::atomic<int> step = 0, attempt = 0, fills = 0;
};
static_assert(std::atomic<int>::is_always_lock_free);

void tell(Told& told, MeshingStep step) {
  told.step = static_cast<int>(step);
}

// What check_and_orient() would blame on the surface is TetGen's doing.
bool is_sound(TetMesh mesh) {
  try {
    check_and_orient(mesh, "mesh");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

constexpr int most_attempts = 14;
constexpr int to_resampled = 3, to_smooth = 7;  // attempts of a graded mesh from which its surface is simpler

class Attempts {
 public:
  // marks: of the closed surface's triangles.
  Attempts(Surface closed, std::vector<int> marks, const TetrahedraliseOptions& options,
           RepairReport& repair_report, Told& told)
      : closed_(std::move(closed)),
        marks_(std::move(marks)),
        options_(options),
        repair_(repair_report),
        told_(told) {}

  TetMesh run() {
    double edge = edge_for(closed_, options_.elements);
    const double first = edge;
    for (int k = 0; k < most_attempts; ++k) {
      told_.attempt = k + 1;
      tell(told_, MeshingStep::resample);
      if (k == to_resampled || k == to_smooth) edge = is_graded(options_) ? first : edge;
      CountedFill fill = is_graded(options_) ? graded(k, edge / first) : even(edge);
      const bool met = meets(fill.mesh, options_.elements);
      if (met && is_sound(*fill.mesh)) return std::move(*fill.mesh);
      if (met) fill = {.mesh = std::nullopt, .problem = "TetGen left flat tetrahedra"};
      if (fill.mesh && std::abs(log_ratio(*fill.mesh)) < std::abs(log_ratio_))
        log_ratio_ = log_ratio(*fill.mesh);
      if (!fill.mesh && ++failures_ == (is_graded(options_) ? to_smooth : 3)) wrap();
      problem_ = fill.problem;
      edge *= fill.too_fine ? 1.1 : 0.94;
    }
    throw InputError(options_.name,
                     fmt::format("{} elements cannot be met within 5 %, {}", options_.elements, excuse()));
  }

  const SizeField& field() const { return field_; }

 private:
  double log_ratio(const TetMesh& mesh) const {
    return std::log(static_cast<double>(mesh.tets.size()) / static_cast<double>(options_.elements));
  }

  CountedFill even(double edge) {
    const Surface surface = skin(edge);
    tell(told_, MeshingStep::fill);
    return fill_to_count(surface, options_.elements, close_enough,
                         {.patience = patience_of(options_), .fills = &told_.fills});
  }

  // scale: of the edges that the number of elements lets expect. Steps and noise of rough surfaces are sharp edges too.
  // They go by and by: first the surface is resampled evenly, then no sharp edge is kept.
  CountedFill graded(int attempt, double scale) {
    const bool resampled = attempt >= to_resampled && marks_.empty();
    const Surface closed =
        resampled ? resample_surface(closed_, uniform_edge(closed_, options_.elements)) : closed_;
    field_ = size_field_of(closed, options_);
    field_.near *= scale, field_.far *= scale;
    const std::optional<GradedSurface> skin = without_intersections(graded_skin(
        closed,
        {.rim = options_.rim, .marks = marks_, .pins = options_.pins, .keep_sharp = attempt < to_smooth},
        field_));
    if (!skin) return {.mesh = std::nullopt, .problem = "its graded surface intersects itself"};
    tell(told_, MeshingStep::fill);
    return fill_graded(*skin, field_, options_.elements, close_enough,
                       {.patience = patience_of(options_), .fills = &told_.fills});
  }

  // The surface with triangles of the right size, without self-intersections.
  Surface skin(double edge) {
    Surface surface = resample_surface(closed_, edge);
    RepairReport unused;
    return intersects_itself(surface) ? repair_surface(surface, unused) : surface;
  }

  void wrap() {
    if (repair_.wrapped || !marks_.empty()) return;  // a wrap has other triangles
    closed_ = alpha_wrap(closed_, bounding_box(closed_).size().norm() / 60);
    repair_.wrapped = true;
  }

  std::string excuse() const {
    if (std::isfinite(log_ratio_))
      return fmt::format("the nearest is {:.0f}",
                         static_cast<double>(options_.elements) * std::exp(log_ratio_));
    return problem_.empty() ? "TetGen gives no mesh" : problem_;
  }

  Surface closed_;
  std::vector<int> marks_;
  SizeField field_;
  const TetrahedraliseOptions& options_;
  RepairReport& repair_;
  Told& told_;
  double log_ratio_ = std::numeric_limits<double>::infinity();
  int failures_ = 0;
  std::string problem_;
};

TetMesh fill_as_given(const Surface& closed, const TetrahedraliseOptions& options, Told& told) {
  const auto patience = patience_of(options);
  tell(told, MeshingStep::fill);
  std::string problem;
  std::optional<TetMesh> mesh = fill_with_tets(closed, {.patience = patience, .fills = &told.fills}, problem);
  if (!mesh)
    mesh =
        fill_with_tets(closed, {.keep_surface = false, .patience = patience, .fills = &told.fills}, problem);
  if (!mesh || mesh->tets.empty())
    throw InputError(options.name, fmt::format("cannot be filled with tetrahedra: {}", problem));
  return std::move(*mesh);
}

TetMesh make(const Surface& input, const TetrahedraliseOptions& options, bool measure,
             TetrahedraliseReport& report, Told& told) {
  TetMesh mesh;
  Surface closed;
  try {
    closed = repair_surface(input, report.repair);
    if (options.elements == 0) {
      mesh = fill_as_given(closed, options, told);
    } else {
      if (report.repair.wrapped && !options.marks.empty())
        throw InputError(options.name,
                         "was rebuilt around, since it cannot be repaired; its groups are lost");
      Attempts attempts(closed, marks_on(closed, input, options.marks), options, report.repair, told);
      mesh = attempts.run();
      report.near = attempts.field().near, report.far = attempts.field().far;
    }
  } catch (const InputError& error) {
    if (error.place().key != "surface" || options.name == "surface") throw;
    throw InputError(options.name, error.problem());
  }
  if (options.length) match_length(mesh, *options.length, bounding_box(input).centre());
  tell(told, MeshingStep::compare);
  // The walls inside a union are no part of it.
  if (measure)
    report.hausdorff = hausdorff_distance(report.repair.united ? closed : input, boundary_surface(mesh));
  return mesh;
}

// ---- the answer of the child process: a report and a mesh, or the words of an error

constexpr int input_error = 10, no_memory = 11, other_error = 12;

bool send(int out, const TetrahedraliseReport& report, const TetMesh& mesh) {
  static_assert(std::is_trivially_copyable_v<TetrahedraliseReport>);
  return write_to(out, &report, sizeof report) && write_to(out, mesh.nodes) && write_to(out, mesh.tets);
}

TetMesh received(const std::string& data, TetrahedraliseReport& report) {
  ChildAnswer answer(data);
  TetMesh mesh;
  answer.take(&report, sizeof report);
  answer.take(mesh.nodes);
  answer.take(mesh.tets);
  return mesh;
}

int send_error(int out, int code, const std::string& key, const std::string& problem) {
  const std::string text = key + '\0' + problem;
  return write_to(out, text.data(), text.size()) ? code : child_cut_short;
}

int make_in_child(int out, const Surface& input, const TetrahedraliseOptions& options, bool measure,
                  Told& told) {
  try {
    TetrahedraliseReport report;
    const TetMesh mesh = make(input, options, measure, report, told);
    return send(out, report, mesh) ? 0 : child_cut_short;
  } catch (const InputError& error) {
    return send_error(out, input_error, error.place().text(), error.problem());
  } catch (const std::bad_alloc&) {
    return no_memory;
  } catch (const std::exception& error) {  // of CGAL
    return send_error(out, other_error, options.name, "cannot be meshed, expected a closed surface");
  }
}

[[noreturn]] void fail(const ChildOutcome& outcome, const TetrahedraliseOptions& options, double limit) {
  using End = ChildOutcome::End;
  switch (outcome.end) {
    case End::late:
      throw InputError(options.name,
                       fmt::format("no mesh was found in {:g} s, the limit of time; expected a "
                                   "cleaner surface, or forefeel mesh with a longer --time-limit",
                                   limit));
    case End::stopped:
      throw InputError(options.name, "interrupted while it was meshed");
    case End::not_begun:
      throw InputError(options.name, fmt::format("cannot be meshed: {}", std::strerror(outcome.code)));
    case End::signalled:
      throw InputError(options.name,
                       fmt::format("cannot be meshed: CGAL or TetGen crashed (signal {})", outcome.code));
    case End::exited:
      break;
  }
  if (outcome.code == no_memory) throw std::bad_alloc();
  const std::size_t middle = outcome.data.find('\0');
  if ((outcome.code == input_error || outcome.code == other_error) && middle != std::string::npos)
    throw InputError(outcome.data.substr(0, middle), outcome.data.substr(middle + 1));
  throw InputError(options.name, "cannot be meshed, expected a closed surface");
}

constexpr double shortest = 1e-6, longest = 1e6;  // bodies that can be solved [m]

void check_side(const Surface& input, const TetrahedraliseOptions& options) {
  const double side = bounding_box(input).size().maxCoeff();
  if (side == 0) throw InputError(options.name, "has no extent, expected a closed surface");
  if (!(side >= shortest && side <= longest))
    throw InputError(options.name,
                     fmt::format("is {:.3g} m long, expected {:g} to {:g} m; --length scales it", side,
                                 shortest, longest));
}

}  // namespace

double default_time_limit(std::size_t elements) {
  return std::max(120.0, static_cast<double>(elements) / 5000);
}

const char* name(MeshingStep step) {
  switch (step) {
    case MeshingStep::repair:
      return "repairing the surface";
    case MeshingStep::resample:
      return "making its triangles as large as wanted";
    case MeshingStep::fill:
      return "filling it with tetrahedra";
    case MeshingStep::compare:
      break;
  }
  return "comparing with the surface";
}

TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report,
                       const std::function<void(const MeshingProgress&)>& show) {
  if (surface.triangles.empty())
    throw InputError(options.name, "holds no triangles, expected a closed surface");
  Surface input = surface;
  if (options.length) scale(input, *options.length, options.name);
  check_side(input, options);
  if (is_graded(options) && options.elements == 0)
    throw InputError(options.name, "a graded mesh needs the number of elements");
  const double limit = options.time_limit.value_or(default_time_limit(options.elements));
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * limit));
  const SharedValue<Told> shared;
  Told& told = *shared;
  const auto tick = [&] {
    if (show)
      show({.step = static_cast<MeshingStep>(told.step.load()),
            .attempt = told.attempt,
            .attempts = options.elements > 0 ? most_attempts : 0,
            .fills = told.fills});
  };
  const ChildOutcome outcome =
      run_apart({.deadline = deadline, .stop = options.stop, .tick = tick},
                [&](int out) { return make_in_child(out, input, options, report != nullptr, told); });
  if (outcome.end != ChildOutcome::End::exited || outcome.code != 0) fail(outcome, options, limit);
  TetrahedraliseReport local;
  return received(outcome.data, report ? *report : local);
}

}  // namespace forefeel
