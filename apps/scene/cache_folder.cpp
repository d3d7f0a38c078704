#include "apps/scene/cache_folder.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/writer_lock.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

bool writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return fs::is_directory(folder, error) && access(folder.c_str(), W_OK) == 0;
}

}  // namespace

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && fs::path(cache).is_absolute() && writable_folder(fs::path(cache) / "forefeel"))
    return fs::path(cache) / "forefeel";
  if (home && *home && writable_folder(fs::path(home) / ".cache" / "forefeel"))
    return fs::path(home) / ".cache" / "forefeel";
  return {};
}

// ---- content

namespace {

constexpr std::size_t hash_length = 32;  // of a name: the digest of what the file depends on

// True for names like "0daad364fd643a1e9daf614e74193ef0.mesh", for SQLite's logs and for leftovers of a killed process.
bool is_of_cache(const std::string& name) {
  std::string_view all = name;
  if (all.starts_with('.') && all.ends_with(".part")) all.remove_prefix(1);  // not written to its end
  if (all.size() <= hash_length ||
      all.substr(0, hash_length).find_first_not_of("0123456789abcdef") != std::string_view::npos)
    return false;
  std::string_view rest = all.substr(hash_length);
  // state files say after a hyphen what they keep: -lattice, -displacements-jet3
  if (rest.starts_with('-'))
    rest.remove_prefix(
        std::min(rest.size(), rest.find_first_not_of("-abcdefghijklmnopqrstuvwxyz0123456789")));
  for (const std::string_view kept :
       {".mesh", ".spacing.json", ".mesh-error.json", ".accuracy.json", ".costs.csv", ".rest-cost.csv",
        ".jet.json", ".sites", ".patches", ".states"})
    if (rest.starts_with(kept)) return true;
  return false;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code of_entry; entry->is_regular_file(of_entry)) files.push_back(entry->path());
  std::ranges::sort(files);
  return files;
}

// The state file that a file belongs to: itself, or the one whose log it is. Empty for other files.
fs::path states_of(const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t end = name.find(".states");
  return end == std::string::npos ? fs::path() : file.parent_path() / name.substr(0, end + 7);
}

void remove(const fs::path& file, CacheContent& removed) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error || !fs::remove(file, error)) return;
  ++removed.files;
  removed.bytes += bytes;
}

}  // namespace

CacheContent cache_content(const fs::path& folder) {
  CacheContent content;
  for (const fs::path& file : files_in(folder)) {
    if (!is_of_cache(file.filename().string())) {
      ++content.foreign;
      continue;
    }
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) continue;
    ++content.files;
    content.bytes += bytes;
  }
  return content;
}

CacheContent empty_cache(const fs::path& folder) {
  CacheContent removed;
  for (const fs::path& file : files_in(folder)) {
    if (!is_of_cache(file.filename().string())) {
      ++removed.foreign;
      continue;
    }
    const fs::path states = states_of(file);
    if (states.empty()) {
      remove(file, removed);
      continue;
    }
    try {
      const WriterLock lock(states);  // no process writes it, and none begins to
      remove(file, removed);
    } catch (const InputError&) {
      ++removed.in_use;
    }
  }
  return removed;
}

using Json = nlohmann::ordered_json;

std::optional<Json> read_kept(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (file.empty() || !in) return {};
  Json kept = Json::parse(in, nullptr, false);
  if (!kept.is_object() || !kept.contains("sha256")) return {};
  const Json sum = kept["sha256"];
  kept.erase("sha256");
  if (sum == sum_of(kept)) return kept;
  warn({}, file.string() + ": has a wrong checksum: it is computed anew");
  return {};
}

void keep(const std::filesystem::path& file, Json result) {
  if (file.empty()) return;
  result["sha256"] = sum_of(result);
  try {
    write_whole(file, json_text(result, 2) + "\n");
  } catch (const std::exception&) {  // for example a full disk; it is computed again next time
  }
}

}  // namespace forefeel
