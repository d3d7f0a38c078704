#pragma once
// The reference that `forefeel help` prints: every key, setting and column, from the tables that the readers
// and writers themselves use.

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel {

struct HelpTopic {
  std::string name, meaning;
  std::vector<DeclaredTable> tables = {};
  std::string_view page = {};  // of the guide, printed before the tables
};

// scene, study, devices, outputs, the pages of the guide, words.
std::vector<HelpTopic> help_topics();
std::vector<HelpTopic> guide_topics();  // guide_topics.cpp; that of studies has its keys as well
HelpTopic words_topic();
// Other words that people look for, and the topic that answers them.
const std::map<std::string, std::string>& help_aliases();
// The table of this name and those nested in it: "session" also gives "session.jnd". Empty if there is none.
std::vector<DeclaredTable> tables_named(const HelpTopic& topic, const std::string& name);

// Text for a terminal of `width` columns.
std::string as_text(const DeclaredTable& table, std::size_t width);
std::string as_html(const std::string& program, const std::vector<HelpTopic>& topics);  // a complete page
nlohmann::ordered_json to_json(const std::vector<HelpTopic>& topics);

}  // namespace forefeel
