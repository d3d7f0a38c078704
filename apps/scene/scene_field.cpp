#include "apps/scene/scene_field.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/kept_pieces.hpp"
#include "apps/scene/scene_fine.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/packer.hpp"
#include "geometry/common/sha256.hpp"
#include "solver/kernels/revision.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view field_magic = "forefeel sites 1\n", patches_magic = "forefeel patches 1\n";
constexpr std::size_t field_digest = 64;  // hexadecimal digits at the end

// magic: of the file's kind; ending: of its name.
fs::path file_of_field(const Scene& scene, double spacing, std::string_view magic, const char* ending) {
  const fs::path folder = cache_folder();
  if (folder.empty()) return {};
  Sha256 hash;
  hash.add(magic).add(solver_revision()).add(spacing);
  for (const auto& [key, value] : scene.identity) hash.add(key + "=" + value + "\n");
  return folder / (hash.hex().substr(0, 32) + ending);
}

struct KeptField {
  std::vector<double> compliance;
  std::vector<FieldSite> sites;
};

template <class Matrix>
void pack(Packer& out, const Matrix& matrix) {
  for (Eigen::Index i = 0; i < matrix.size(); ++i) out.add(matrix.data()[i]);
}
template <class Matrix>
void unpack(Unpacker& in, Matrix& matrix) {
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = in.number<double>();
}

// With their checksum.
std::string signed_bytes(Packer& out) {
  const Bytes packed = out.take();
  std::string bytes(packed.begin(), packed.end());
  return bytes + Sha256().add(bytes).hex();
}

// Without magic and checksum; none where these are wrong.
std::optional<std::string_view> checked_bytes(std::string_view bytes, std::string_view magic) {
  if (bytes.size() < magic.size() + field_digest || !bytes.starts_with(magic)) return {};
  const std::string_view sum = bytes.substr(bytes.size() - field_digest);
  bytes.remove_suffix(field_digest);
  if (Sha256().add(bytes).hex() != sum) return {};
  return bytes.substr(magic.size());
}

std::string bytes_of(const KeptField& kept) {
  Packer out;
  out.add_raw(field_magic);
  out.add(kept.compliance);
  out.add(std::uint64_t{kept.sites.size()});
  for (const FieldSite& site : kept.sites) {
    out.add(site.place.facet);
    for (const auto* part : {&site.place.at, &site.normal}) pack(out, *part);
    pack(out, site.stiffness);
    pack(out, site.own);
  }
  return signed_bytes(out);
}

std::optional<KeptField> field_of_bytes(std::string_view all) {
  const std::optional<std::string_view> bytes = checked_bytes(all, field_magic);
  if (!bytes) return {};
  KeptField kept;
  try {
    Unpacker in(Bytes(bytes->begin(), bytes->end()));
    kept.compliance = in.values<double>();
    for (auto left = in.number<std::uint64_t>(); left > 0; --left) {
      FieldSite& site = kept.sites.emplace_back();
      site.place.facet = in.number<std::int32_t>();
      for (auto* part : {&site.place.at, &site.normal}) unpack(in, *part);
      unpack(in, site.stiffness);
      unpack(in, site.own);
    }
    if (in.left() > 0) return {};
  } catch (const MalformedMessage&) {
    return {};
  }
  return kept;
}

std::optional<std::vector<double>> patches_of_bytes(std::string_view all) {
  const std::optional<std::string_view> bytes = checked_bytes(all, patches_magic);
  if (!bytes) return {};
  try {
    return Unpacker(Bytes(bytes->begin(), bytes->end())).values<double>();
  } catch (const MalformedMessage&) {
    return {};
  }
}

// read: from the file's bytes; none where they are wrong.
template <class Read>
auto read_cached(const fs::path& file, Read read) -> decltype(read(std::string_view())) {
  std::ifstream in(file, std::ios::binary);
  if (file.empty() || !in) return {};
  std::ostringstream bytes;
  bytes << in.rdbuf();
  auto kept = read(bytes.view());
  if (!kept) warn({}, file.string() + ": has a wrong checksum: it is computed anew");
  return kept;
}

void write_cached(const fs::path& file, const std::string& bytes) {
  if (file.empty()) return;
  try {
    write_whole(file, bytes);
  } catch (const std::exception&) {  // for example a full disk; it is computed again next time
  }
}

// Beside the file of the whole.
fs::path pieces_of(const fs::path& file) {
  return file.empty() ? file : fs::path(file.string() + ".part");
}

// That a touch anywhere is answered for.
std::shared_ptr<const Body> answered_body(const Scene& scene) {
  const std::shared_ptr<const FineBodies>& fine = scene.touch.anywhere->fine;
  return fine ? std::shared_ptr<const Body>(fine, &fine->first) : scene.body;
}

void check_sizes(const Scene& scene, const Body& body, double spacing) {
  constexpr double most_sites = 20'000;  // CoverOptions
  const std::string file = scene.source.file.string();
  if (const double longest = longest_side(body.mesh); body.pad->radius > longest)
    throw InputError(
        {.file = file, .key = "contact.radius"},
        fmt::format("is {:g} m, longer than the body, expected at most {:.3g}", body.pad->radius, longest));
  const double area = SurfaceMap(body).free_area(), sites = area / (spacing * spacing);
  if (sites > most_sites)
    throw InputError({.file = file, .key = "contact.site_spacing"},
                     fmt::format("is {:g} m, which needs about {:.2g} sites, expected at least {:.2g} m",
                                 spacing, sites, std::sqrt(area / most_sites)));
}

// Shows shares; the first is what an earlier run has done.
std::function<void(double)> shown_by(Progress& progress, const char* what) {
  return [&progress, what, first = true](double share) mutable {
    if (std::exchange(first, false)) progress.begin(share, what);
    progress.show(share, what);
  };
}

// Says what a field will cost, once its first pieces are measured.
class FieldCost {
 public:
  FieldCost(const Scene& scene, const Body& body, const SiteFieldOptions& options, Progress& progress)
      : fine_(scene.touch.anywhere->fine != nullptr), threads_(options.threads), progress_(progress) {
    const SurfaceMap map(body);
    const auto facets = static_cast<double>(map.facets().size());
    const double nodes = body.element == Element::quadratic ? 2 * facets : facets / 2,
                 sites = map.free_area() / (options.spacing * options.spacing);
    whole_ = (1 + jets * sites / nodes) * facets_too;
    what_ = fmt::format("{} {} elements", body.mesh.tets.size(), name(body.element));
  }

  void show(double share) {
    const auto now = std::chrono::steady_clock::now();
    ++calls_;
    if (calls_ <= threads_ + 2) start_ = now, first_ = share;  // what is kept; then each thread's factor
    const double seconds = std::chrono::duration<double>(now - start_).count();
    if (said_ || seconds < measured || calls_ < 2 * threads_ + 6) return;
    said_ = true;
    const double left = seconds / (share - first_) * (whole_ - share);
    if (left < worth_saying) return;
    progress_.note(fmt::format(
        "The field at rest of {} takes about {} more; it is kept piece by piece, and a "
        "rerun resumes. Quicker: {}",
        what_, rough_time(left), fine_ ? "--set body.fine=false" : "a larger contact.site_spacing"));
  }

 private:
  // Measured on phantoms: seconds of a jet over those of a surface node's columns, and of all over those of both.
  static constexpr double jets = 13, facets_too = 1.4;
  static constexpr double measured = 2, worth_saying = 15;  // [s]

  bool fine_, said_ = false;
  int threads_;
  Progress& progress_;
  double whole_ = 1;  // the field's time over its compliance's
  std::string what_;
  int calls_ = 0;
  double first_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

std::shared_ptr<const RestSites> rest_sites_of(const Scene& scene) {
  return std::make_shared<const RestSites>(answered_body(scene), 1);
}

FieldFound find_field(const Scene& scene, const Globals& globals, const std::stop_token& stop) {
  const auto start = std::chrono::steady_clock::now();
  SiteFieldOptions options;
  options.threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  options.spacing = scene.touch.anywhere->site_spacing.value_or(options.spacing);
  const std::shared_ptr<const Body> body = answered_body(scene);
  check_sizes(scene, *body, options.spacing);
  const fs::path file = file_of_field(scene, options.spacing, field_magic, ".sites");
  FieldFound found;
  if (const std::optional<KeptField> kept = read_cached(file, field_of_bytes)) {
    const auto rest = std::make_shared<const RestSites>(body, options.threads, kept->compliance);
    found.field = std::make_shared<const SiteField>(rest, options, kept->sites);
    found.kept = true;
  } else {
    Progress progress(globals, "Field at rest (1 of 3)");
    PieceFile pieces(pieces_of(file));
    FieldCost cost(scene, *body, options, progress);
    const auto rest = std::make_shared<const RestSites>(
        body, options.threads, std::span<const double>(),
        [&cost, show = shown_by(progress, "compliance of the surface")](double share) {
          show(share);
          cost.show(share);
        },
        &pieces);
    progress.phase("Field at rest (2 of 3)");
    found.field =
        std::make_shared<const SiteField>(rest, options, shown_by(progress, "jets of sites"), stop, &pieces);
    if (!stop.stop_requested()) {
      write_cached(file, bytes_of({found.field->rest().compliance(), found.field->sites()}));
      pieces.remove();
    }
  }
  found.seconds = seconds_since(start);
  return found;
}

std::shared_ptr<const FieldPatches> find_patches(const Scene& scene, std::shared_ptr<const SiteField> field,
                                                 const Globals& globals, const std::stop_token& stop) {
  const fs::path file = file_of_field(scene, field->options().spacing, patches_magic, ".patches");
  const std::optional<std::vector<double>> kept = read_cached(file, patches_of_bytes);
  Progress progress(globals, "Field at rest (3 of 3)");
  PieceFile pieces(kept ? fs::path() : pieces_of(file));
  const auto patches =
      std::make_shared<const FieldPatches>(std::move(field), kept ? *kept : std::vector<double>(),
                                           shown_by(progress, "places on facets"), stop, &pieces);
  if (!stop.stop_requested() && (!kept || kept->size() != patches->values().size())) {
    Packer out;
    out.add_raw(patches_magic);
    out.add(patches->values());
    write_cached(file, signed_bytes(out));
    pieces.remove();
  }
  return patches;
}

std::shared_ptr<const SiteField> site_field_of(const Scene& scene, const Globals& globals,
                                               const std::stop_token& stop) {
  return find_field(scene, globals, stop).field;
}

}  // namespace forefeel
