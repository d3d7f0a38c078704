#pragma once
// The keys that a command prints with --json are those that its help lists.

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel::test {

// Compares the keys of documents with the table of help that has this name. rare: listed, but not in these documents.
void compare_keys(const std::vector<DeclaredTable>& tables, const std::string& table,
                  const std::vector<nlohmann::json>& documents, const std::set<std::string>& rare = {});

}  // namespace forefeel::test
