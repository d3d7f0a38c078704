#include "apps/scene/kept_json.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/json_text.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {

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
