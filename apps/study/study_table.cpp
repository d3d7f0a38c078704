#include "apps/study/study_table.hpp"
#include "apps/console/json.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace forefeel {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

std::string shown(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? quoted(value.get<std::string>()) : value.dump();
}

std::vector<std::string> result_keys(const Study& study, const std::vector<CellColumns>& cells) {
  std::set<std::string> taken{"seed"};
  for (const StudyAxis& axis : study.axes) taken.insert(axis.column);
  std::vector<std::string> keys;
  for (const CellColumns& cell : cells)
    for (const auto& [key, value] : cell.items())
      if (taken.insert(key).second) keys.push_back(key);
  return keys;
}

std::optional<std::size_t> policy_axis(const Study& study) {
  for (std::size_t i = 0; i < study.axes.size(); ++i)
    if (study.axes[i].column == "policy" || study.axes[i].column == "session.policy") return i;
  return {};
}

}  // namespace

double cell_number(const CellColumns& cell, const std::string& key) {
  const auto found = cell.find(key);
  return found != cell.end() && found->is_number() ? found->get<double>() : std::nan("");
}

std::vector<std::size_t> blocks_without(const Study& study, std::size_t axis) {
  std::map<std::vector<std::size_t>, std::size_t> numbers;
  std::vector<std::size_t> blocks;
  for (std::size_t c = 0; c < study.combinations(); ++c)
    for (std::size_t s = 0; s < study.seeds.size(); ++s) {
      std::vector<std::size_t> rest = study.choice(c);
      rest[axis] = 0;
      rest.push_back(s);
      blocks.push_back(numbers.try_emplace(rest, numbers.size()).first->second);
    }
  return blocks;
}

void add_regret(const Study& study, std::vector<CellColumns>& cells) {
  const std::optional<std::size_t> axis = policy_axis(study);
  if (!axis) return;
  const std::vector<StudyValue>& policies = study.axes[*axis].values;
  const auto best = std::ranges::find(policies, std::string("clairvoyant"), &StudyValue::text);
  if (best == policies.end()) return;
  const std::vector<std::size_t> blocks = blocks_without(study, *axis);
  std::map<std::size_t, std::size_t> bound;  // block -> cell of the clairvoyant policy
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (study.choice(i / study.seeds.size())[*axis] == static_cast<std::size_t>(best - policies.begin()))
      bound[blocks[i]] = i;
  for (const std::string key : {"within_jnd", "first_visit.within_jnd"})
    for (std::size_t i = 0; i < cells.size(); ++i)
      cells[i]["regret." + key] = number(cell_number(cells[bound.at(blocks[i])], "error." + key) -
                                         cell_number(cells[i], "error." + key));
}

std::string cells_csv(const Study& study, const std::vector<CellColumns>& cells) {
  const std::vector<std::string> keys = result_keys(study, cells);
  std::string text;
  for (const StudyAxis& axis : study.axes) text += quoted(axis.column) + ',';
  text += "seed";
  for (const std::string& key : keys) text += ',' + quoted(key);
  text += '\n';
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::vector<std::size_t> choice = study.choice(i / study.seeds.size());
    for (std::size_t a = 0; a < choice.size(); ++a)
      text += quoted(study.axes[a].values[choice[a]].text) + ',';
    text += std::to_string(study.seeds[i % study.seeds.size()]);
    for (const std::string& key : keys) {
      text += ',';
      if (const auto found = cells[i].find(key); found != cells[i].end()) text += shown(*found);
    }
    text += '\n';
  }
  return text;
}

}  // namespace forefeel
