#include "apps/session/all_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "apps/console/json.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/picture/page.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

std::string printed(const Json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return html_escaped(value.get<std::string>());
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  if (value.is_array()) {
    std::string text;
    for (const Json& element : value) text += (text.empty() ? "" : ", ") + printed(element);
    return text;
  }
  return html_escaped(json_text(value));
}

bool is_list_of_rows(const Json& value) {
  return value.is_array() && !value.empty() && value.front().is_object();
}

void rows_of(const Json& value, const std::string& path, std::string& html) {
  if (value.is_object()) {
    for (const auto& [key, child] : value.items())
      rows_of(child, path.empty() ? key : path + "." + key, html);
  } else {
    html += fmt::format("<tr><td>{}</td><td class=\"n\">{}</td></tr>\n", html_escaped(path), printed(value));
  }
}

// "horizon [s]": a column of the tables of predictors.
std::string titled(const std::string& key) {
  const std::vector<Declared> columns = declared(prediction_keys());
  const auto column = std::ranges::find(columns, key, &Declared::name);
  return column == columns.end() || column->unit == "1" ? key : key + " [" + column->unit + "]";
}

// A list of objects with the same keys as a table with these columns.
std::string rows_table(const std::string& title, const Json& rows) {
  std::string html = fmt::format("<h3>{}</h3>\n<div class=\"scroll\"><table><tr>", html_escaped(title));
  for (const auto& [key, value] : rows.front().items()) html += "<th>" + html_escaped(titled(key)) + "</th>";
  html += "</tr>\n";
  for (const Json& row : rows) {
    html += "<tr>";
    for (const auto& [key, value] : row.items()) html += "<td class=\"n\">" + printed(value) + "</td>";
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

// Moves the lists of objects out of a document into tables of their own.
std::string take_lists(const std::string& path, Json& value) {
  std::string html;
  std::vector<std::string> taken;
  for (auto& [key, child] : value.items()) {
    const std::string name = path.empty() ? key : path + "." + key;
    if (is_list_of_rows(child)) {
      html += rows_table(name, child);
      taken.push_back(key);
    } else if (child.is_object()) {
      html += take_lists(name, child);
      if (child.empty()) taken.push_back(key);
    }
  }
  for (const std::string& key : taken) value.erase(key);
  return html;
}

// Takes out what is not known, and groups of nothing else: rows of dashes. A list keeps its columns.
void drop_unknown(Json& object) {
  for (auto child = object.begin(); child != object.end();) {
    if (child->is_object()) drop_unknown(*child);
    const bool nothing = child->is_null() || ((child->is_object() || child->is_array()) && child->empty());
    child = nothing ? object.erase(child) : std::next(child);
  }
}

}  // namespace

std::string all_numbers(nlohmann::ordered_json document) {
  std::string html =
      "<details><summary>All numbers (SI; shares from 0 to 1)</summary>\n<div class=\"columns\">\n";
  for (const char* elsewhere : {"provenance", "notes", "attention"}) document.erase(elsewhere);
  drop_unknown(document);
  if (document.contains("error"))
    for (const char* key : {"by_label", "by_trusted"})
      document["error"].erase(key);  // in a table of their own
  const std::string lists = take_lists("", document);
  std::string single;
  for (const auto& [key, value] : document.items()) {
    if (!value.is_object()) {
      rows_of(value, key, single);
      continue;
    }
    std::string rows;
    rows_of(value, "", rows);
    html += fmt::format("<table><tr><th colspan=\"2\">{}</th></tr>\n{}</table>\n", html_escaped(key), rows);
  }
  return html + "<table><tr><th colspan=\"2\">session</th></tr>\n" + single + "</table>\n</div>\n" + lists +
         "</details>\n";
}

std::string provenance_section(const nlohmann::ordered_json& document) {
  std::string rows;
  if (const auto found = document.find("provenance"); found != document.end()) rows_of(*found, "", rows);
  return "<h2>Provenance</h2>\n<table class=\"wide\">\n" + rows + "</table>\n";
}

}  // namespace forefeel
