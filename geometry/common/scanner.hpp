#pragma once
// Reads text and binary values from one file held in memory. Every failure is an InputError that names file
// and line, or file and byte within binary data. Used by the readers of meshes and surfaces.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/error.hpp"

namespace forefeel {

// The whole content. InputError if the file is missing, a folder, unreadable, empty, larger than the memory that
// is left, or a device or pipe of more than 1 GB.
std::string read_file(const std::filesystem::path& file);
// The whole content of a text: also InputError for a line above 1 MiB, found before the rest is read.
std::string read_text_file(const std::filesystem::path& file);
std::string read_start(const std::filesystem::path& file,
                       std::size_t bytes);  // only the first bytes; the same errors
std::string lower_case(std::string_view text);
std::string_view trimmed(std::string_view text);
std::vector<std::string_view> words_of(std::string_view line);  // between blanks
bool parse_real(std::string_view text, double& value);          // whole text is one number (nan, inf allowed)
bool parse_integer(std::string_view text, std::int64_t& value);

template <class T>
T byte_swapped(T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

class Scanner {
 public:
  Scanner(std::string content, std::string name) : content_(std::move(content)), name_(std::move(name)) {}

  // Text. Tokens are separated by white space; comment(c): from c to the end of line is skipped.
  void comment(char mark) { comment_ = mark; }
  bool at_end();                                 // nothing but white space and comments is left
  std::string_view token(const char* expected);  // InputError "ends where <expected> was expected"
  std::string_view peek();                       // the next token, which stays; empty at the end
  double real(const char* expected);
  std::int64_t integer(const char* expected);
  std::int64_t integer(const char* expected, std::int64_t low, std::int64_t high);
  // A count of items of at least bytes_each. A count that the file cannot hold is an error before anything is
  // allocated.
  std::size_t count(const char* expected, std::size_t bytes_each);
  bool line(std::string_view& out);  // rest of this line without its end; false at the end
  // Past the next occurrence of word at the beginning of a line; false if there is none.
  bool skip_past_line(std::string_view word);
  bool skip_past_word(std::string_view word);  // wherever it stands, before white space or the end

  // Binary values begin at the byte after what was read last.
  void swap_bytes(bool on) { swap_ = on; }
  bool swaps_bytes() const { return swap_; }
  std::size_t remaining() const { return content_.size() - position_; }
  std::string_view bytes(std::size_t n, const char* expected);
  template <class T>
  T raw(const char* expected) {
    T value;
    std::memcpy(&value, bytes(sizeof(T), expected).data(), sizeof(T));
    return swap_ ? byte_swapped(value) : value;
  }
  void check_count(std::uint64_t n, std::size_t bytes_each, const char* what);

  std::size_t position() const { return position_; }
  void seek(std::size_t position) { position_ = position; }
  const std::string& name() const { return name_; }
  std::string_view content() const { return content_; }
  InputPlace where() const;                                         // file and line of the token read last
  [[noreturn]] void fail(const std::string& problem) const;         // at the token read last
  [[noreturn]] void fail_binary(const std::string& problem) const;  // at this byte

 private:
  void skip_space();

  std::string content_, name_;
  std::size_t position_ = 0, token_ = 0;  // token_: start of the token read last
  mutable std::size_t counted_ = 0,
                      line_ = 1;  // bytes whose lines are counted; where() is asked for each face
  char comment_ = 0;
  bool swap_ = false;
};

}  // namespace forefeel
