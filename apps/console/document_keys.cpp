#include "apps/console/document_keys.hpp"

#include <algorithm>
#include <cctype>

namespace forefeel {
namespace {

bool is_any_name(std::string_view part) {
  return !part.empty() && std::ranges::all_of(part, [](unsigned char c) { return std::isupper(c) != 0; });
}

}  // namespace

Json json_numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

void put(Json& document, const std::string& name, Json value) {
  Json* place = &document;
  std::size_t begin = 0;
  for (std::size_t dot; (dot = name.find('.', begin)) != std::string::npos; begin = dot + 1) {
    const std::size_t next = std::min(name.find('.', dot + 1), name.size());
    place = &(*place)[name.substr(begin, dot - begin)];
    if (is_any_name(std::string_view(name).substr(dot + 1, next - dot - 1))) {
      *place = std::move(value);
      return;
    }
  }
  const std::string last = name.substr(begin);
  if (last.find(',') == std::string::npos) {
    (*place)[last] = std::move(value);
    return;
  }
  begin = 0;
  for (Json& one : value) {
    const std::size_t end = std::min(last.find(',', begin), last.size());
    (*place)[last.substr(begin, end - begin)] = std::move(one);
    begin = end + 1;
  }
}

std::vector<Declared> below(const std::string& key, std::vector<Declared> rows) {
  for (Declared& row : rows) row.name = key + "." + row.name;
  return rows;
}

}  // namespace forefeel
