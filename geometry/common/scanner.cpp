#include "geometry/common/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "geometry/common/memory.hpp"

namespace forefeel {
namespace {

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

namespace {

constexpr std::size_t longest_line = 1 << 20, largest_stream = 1'000'000'000, small_file = 64'000'000;

// Detects a line that is too long while the content is being read.
class LineCheck {
 public:
  explicit LineCheck(const std::filesystem::path& file) : file_(file) {}
  void take(std::string_view block) {
    const bool returns = block.find('\r') != std::string_view::npos;  // rare, and slow to look for as well
    for (;;) {
      const std::size_t end = returns ? block.find_first_of("\r\n") : block.find('\n');
      length_ += std::min(end, block.size());
      if (length_ > longest_line)
        throw InputError({.file = file_.string(), .line = line_},
                         fmt::format("a line of more than {} bytes, expected a text", longest_line));
      if (end == std::string_view::npos) return;
      block.remove_prefix(end + 1);
      length_ = 0;
      ++line_;
    }
  }

 private:
  const std::filesystem::path& file_;
  std::size_t line_ = 1, length_ = 0;
};

void check_size(const std::filesystem::path& file, std::uintmax_t bytes) {
  if (bytes < small_file) return;
  const double left = available_memory();
  if (static_cast<double>(bytes) > left)
    throw InputError({.file = file.string()},
                     fmt::format("is {} large, but {} of memory are left, expected a smaller file",
                                 bytes_in_words(static_cast<double>(bytes)), bytes_in_words(left)));
}

// A text without its byte order mark; one whose lines end in CR alone gets line feeds.
void as_lines(std::string& content) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (content.starts_with(byte_order_mark)) content.erase(0, byte_order_mark.size());
  if (content.find('\r') != std::string::npos && content.find('\n') == std::string::npos &&
      content.find('\0') == std::string::npos)
    std::ranges::replace(content, '\r', '\n');
}

std::string read_blocks(const std::filesystem::path& file, std::size_t bytes, LineCheck* lines) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw InputError({.file = file.string()}, "is a folder, expected a file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream)
    throw InputError({.file = file.string()}, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::string content;
  const auto size = std::filesystem::file_size(file, error);
  if (!error) check_size(file, std::min<std::uintmax_t>(size, bytes));
  if (!error) content.reserve(std::min<std::size_t>(size, bytes) + 1);
  char block[1 << 16];
  while (content.size() < bytes) {
    const std::size_t n = std::fread(block, 1, std::min(sizeof block, bytes - content.size()), stream.get());
    if (n == 0) break;
    if (lines) lines->take({block, n});
    if (content.size() + n > largest_stream && !std::filesystem::is_regular_file(file, error))
      throw InputError({.file = file.string()},
                       "is a device or pipe without an end within 1 GB, expected a file");
    content.append(block, n);
  }
  if (std::ferror(stream.get()))
    throw InputError({.file = file.string()}, fmt::format("cannot be read: {}", std::strerror(errno)));
  if (content.empty()) throw InputError({.file = file.string()}, "is empty");
  as_lines(content);
  return content;
}

}  // namespace

std::string read_file(const std::filesystem::path& file) {
  return read_blocks(file, std::string::npos, nullptr);
}

std::string read_text_file(const std::filesystem::path& file) {
  LineCheck lines(file);
  std::string text = read_blocks(file, std::string::npos, &lines);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw InputError({.file = file.string()}, "is UTF-16, expected UTF-8");
  return text;
}

std::string read_start(const std::filesystem::path& file, std::size_t bytes) {
  return read_blocks(file, bytes, nullptr);
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return result;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> result;
  while (!(line = trimmed(line)).empty()) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    result.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return result;
}

bool parse_real(std::string_view text, double& value) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || text.empty()) return false;
  if (error == std::errc::result_out_of_range) {  // 1e-400 is 0, 1e400 is not a number
    value = std::strtod(std::string(text).c_str(), nullptr);
    return std::abs(value) < 1;
  }
  return error == std::errc{};
}

bool parse_integer(std::string_view text, std::int64_t& value) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

void Scanner::skip_space() {
  while (position_ < content_.size()) {
    const char c = content_[position_];
    if (is_space(c)) {
      ++position_;
    } else if (comment_ != 0 && c == comment_) {
      position_ = std::min(content_.find('\n', position_), content_.size());
    } else {
      return;
    }
  }
}

bool Scanner::at_end() {
  skip_space();
  return position_ == content_.size();
}

std::string_view Scanner::token(const char* expected) {
  skip_space();
  token_ = position_;
  while (position_ < content_.size() && !is_space(content_[position_]) &&
         (comment_ == 0 || content_[position_] != comment_))
    ++position_;
  if (position_ == token_) fail(fmt::format("the file ends where {} was expected", expected));
  return std::string_view(content_).substr(token_, position_ - token_);
}

std::string_view Scanner::peek() {
  if (at_end()) return {};
  const std::size_t start = position_;
  const std::string_view result = token("");
  position_ = start;
  return result;
}

double Scanner::real(const char* expected) {
  const std::string_view text = token(expected);
  double value = 0;
  if (!parse_real(text, value)) fail(fmt::format("'{:.40}' is not a number, expected {}", text, expected));
  return value;
}

std::int64_t Scanner::integer(const char* expected) {
  const std::string_view text = token(expected);
  std::int64_t value = 0;
  if (!parse_integer(text, value))
    fail(fmt::format("'{:.40}' is not a whole number, expected {}", text, expected));
  return value;
}

std::int64_t Scanner::integer(const char* expected, std::int64_t low, std::int64_t high) {
  const std::int64_t value = integer(expected);
  if (value < low || value > high)
    fail(fmt::format("{} is out of range, expected {} from {} to {}", value, expected, low, high));
  return value;
}

namespace {
// "a number of nodes" -> "nodes"
std::string_view counted(std::string_view expected) {
  constexpr std::string_view article = "a number of ";
  return expected.starts_with(article) ? expected.substr(article.size()) : expected;
}
}  // namespace

std::size_t Scanner::count(const char* expected, std::size_t bytes_each) {
  const std::int64_t value = integer(expected);
  if (value < 0) fail(fmt::format("{} is negative, expected {}", value, expected));
  if (static_cast<std::uint64_t>(value) > (remaining() + 1) / bytes_each)
    fail(fmt::format("{} {} announced, but the file is cut short", value, counted(expected)));
  return static_cast<std::size_t>(value);
}

void Scanner::check_count(std::uint64_t n, std::size_t bytes_each, const char* what) {
  if (n > remaining() / bytes_each)
    fail_binary(fmt::format("{} {} announced, but the file is cut short", n, what));
}

bool Scanner::line(std::string_view& out) {
  if (position_ >= content_.size()) return false;
  token_ = position_;
  const std::size_t end = std::min(content_.find('\n', position_), content_.size());
  out = std::string_view(content_).substr(position_, end - position_);
  if (!out.empty() && out.back() == '\r') out.remove_suffix(1);
  position_ = std::min(end + 1, content_.size());
  return true;
}

bool Scanner::skip_past_line(std::string_view word) {
  for (std::size_t found = content_.find(word, position_); found != std::string::npos;
       found = content_.find(word, found + 1)) {
    if (found != 0 && content_[found - 1] != '\n') continue;
    position_ = found + word.size();
    return true;
  }
  return false;
}

bool Scanner::skip_past_word(std::string_view word) {
  for (std::size_t found = content_.find(word, position_); found != std::string::npos;
       found = content_.find(word, found + 1)) {
    const std::size_t end = found + word.size();
    if (end < content_.size() && !is_space(content_[end])) continue;
    position_ = end;
    return true;
  }
  return false;
}

std::string_view Scanner::bytes(std::size_t n, const char* expected) {
  if (n > remaining()) fail_binary(fmt::format("the file ends where {} was expected", expected));
  const std::string_view result = std::string_view(content_).substr(position_, n);
  position_ += n;
  return result;
}

InputPlace Scanner::where() const {
  const std::size_t at = std::min(token_, content_.size());
  if (at < counted_) counted_ = 0, line_ = 1;
  const auto place = [&](std::size_t byte) { return content_.begin() + static_cast<std::ptrdiff_t>(byte); };
  line_ += static_cast<std::size_t>(std::count(place(counted_), place(at), '\n'));
  counted_ = at;
  return {.file = name_, .line = line_};
}

void Scanner::fail(const std::string& problem) const {
  throw InputError(where(), problem);
}

void Scanner::fail_binary(const std::string& problem) const {
  throw InputError({.file = name_, .key = fmt::format("byte {}", position_)}, problem);
}

}  // namespace forefeel
