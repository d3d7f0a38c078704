#pragma once
// Reads the file of a run's inputs record by record (render/input_format.hpp), with little memory however long it is.
// The file of an interrupted run ends within a record, or without the end record; its complete records are used.
// Anything else that is no record is damage.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "scheduling/render/input_format.hpp"

namespace forefeel {

struct InputRecord {
  InputKind kind = InputKind::end;
  Bytes content;
  std::uint64_t at = 0;  // where it begins in the file [bytes]
};

class InputReader {
 public:
  // InputError: no such file, another format, or a damaged header.
  explicit InputReader(std::filesystem::path file);

  const InputHeader& header() const { return header_; }
  // The next record; none at the end. InputError where the bytes are no record.
  std::optional<InputRecord> next();
  bool whole() const { return whole_; }  // the record of the end was read
  std::uint64_t bytes() const { return bytes_; }

  // Throws InputError: the file is damaged at this record.
  [[noreturn]] void refuse(const InputRecord& record, const std::string& problem) const;

 private:
  std::optional<InputRecord> read();

  std::filesystem::path file_;
  std::ifstream in_;
  std::uint64_t at_ = 0, bytes_ = 0;
  bool whole_ = false;
  InputHeader header_;
};

}  // namespace forefeel
