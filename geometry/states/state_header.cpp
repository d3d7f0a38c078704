#include "geometry/states/state_header.hpp"

#include <fmt/format.h>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

std::string shown(const BodyIdentity& identity, const std::string& key) {
  const auto found = identity.find(key);
  if (found == identity.end()) return "none";
  const bool digest =
      found->second.find("sha256") != std::string::npos;  // the beginning of a hash is enough to compare
  return digest && found->second.size() > 24 ? found->second.substr(0, 24) + "…" : found->second;
}

}  // namespace

std::string differing_keys(const BodyIdentity& in_file, const BodyIdentity& ours) {
  BodyIdentity keys = in_file;
  keys.insert(ours.begin(), ours.end());
  std::string differs;
  for (const auto& [key, value] : keys) {
    const auto a = in_file.find(key), b = ours.find(key);
    if (a != in_file.end() && b != ours.end() && a->second == b->second) continue;
    differs += fmt::format("{}{} (file {}, here {})", differs.empty() ? "" : ", ", key, shown(in_file, key),
                           shown(ours, key));
  }
  return differs;
}

void check_same_body(const std::string& file, const BodyIdentity& in_file, const BodyIdentity& ours) {
  if (ours.empty() || in_file.empty()) return;
  if (const std::string differs = differing_keys(in_file, ours); !differs.empty())
    throw InputError({.file = file}, fmt::format("belongs to another body, different: {}", differs));
}

}  // namespace forefeel
