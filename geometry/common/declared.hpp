#pragma once
// Describes keys, arguments and columns. The readers and writers of files use the same tables as
// `forefeel help`, so the help text is never out of date.

#include <string>
#include <vector>

namespace forefeel {

struct Declared {
  std::string name;      // as written in a file; columns of a vector share a row: "x,y,z"
  std::string unit;      // "s"; "1" for shares and ratios; empty for words and counts
  std::string standard;  // the value where none is given; empty where there is none
  std::string meaning;   // one line
};

struct DeclaredTable {
  std::string name;     // "session.limits", "frames.csv"
  std::string meaning;  // one line
  std::vector<Declared> rows = {};
};

inline std::vector<std::string> names_of(const std::vector<Declared>& rows) {
  std::vector<std::string> names;
  for (const Declared& row : rows) names.push_back(row.name);
  return names;
}

// "t,x,y,z": the header line of a table with these columns, without the line break.
inline std::string header_of(const std::vector<Declared>& columns) {
  std::string header;
  for (const Declared& column : columns) header += (header.empty() ? "" : ",") + column.name;
  return header;
}

}  // namespace forefeel
