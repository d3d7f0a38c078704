#pragma once
// The rooms (sub-folders) of the sources: compares the table rooms.txt with the actual includes.
//
// A unit is a header with the source file of the same stem.
// An arrow a -> b says: a file of a includes a header of b.

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace forefeel::house {

using Names = std::set<std::string>;

struct Table {
  std::vector<std::string> rooms;                                       // in order, lower rooms first
  std::map<std::string, Names> allowed;                                 // room -> rooms that it may include
  std::vector<std::pair<std::string, std::vector<std::string>>> heavy;  // header pattern -> file patterns
};
Table read_table(const std::filesystem::path& file);

struct Include {
  std::string file;  // relative to the root
  int line;
  std::string header;
  bool quoted;  // "…" rather than <…>
};
std::vector<Include> read_includes(const std::filesystem::path& root);

std::string room_of(const std::string& file);  // "solver/body/law.cpp" -> "solver/body"
std::string unit_of(const std::string& file);  // -> "solver/body/law"

// Each of these returns one line per fault, and nothing if there is none.
std::vector<std::string> faults_of_table(const Table& table, const std::vector<Include>& includes);
std::vector<std::string> forbidden_includes(const Table& table, const std::vector<Include>& includes);
std::vector<std::string> misplaced_heavy_headers(const Table& table, const std::vector<Include>& includes);
std::vector<std::string> room_cycles(const std::vector<Include>& includes);  // "a/b -> a/c -> a/b (…)"
std::vector<std::string> unit_cycles(const std::vector<Include>& includes);

// The rooms in the table's order with what each includes; forbidden arrows are marked "!!".
std::string drawing(const Table& table, const std::vector<Include>& includes);

}  // namespace forefeel::house
