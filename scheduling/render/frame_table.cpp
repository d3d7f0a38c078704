#include "scheduling/render/frame_table.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <system_error>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/render/input_format.hpp"

namespace forefeel {
namespace {

constexpr std::array<std::string_view, 9> columns = {"x",  "y",          "z",          "fx",        "fy",
                                                     "fz", "rendered_x", "rendered_y", "rendered_z"};

bool is_row_of(const CsvTable& table, std::size_t row, const FrameInput& frame) {
  const auto vector = [&](std::size_t first) {
    return Vec3(table.at(row, first), table.at(row, first + 1), table.at(row, first + 2));
  };
  return vector(0) == frame.at && vector(3) == frame.sent && vector(6) == frame.rendered;
}

}  // namespace

std::size_t compare_frame_table(const std::filesystem::path& table, const std::filesystem::path& inputs) {
  std::error_code error;
  if (!std::filesystem::exists(table, error)) return 0;
  const CsvTable rows = read_csv(table, columns);
  InputReader reader(inputs);
  std::size_t row = 0;
  while (row < rows.rows()) {
    const std::optional<InputRecord> record = reader.next();
    if (!record) break;
    if (record->kind != InputKind::frame) continue;
    Unpacker content(record->content);
    if (!is_row_of(rows, row, unpack_frame(content)))
      throw InputError({.file = table.string(), .line = rows.lines[row]},
                       fmt::format("frame {} is not that of {}: expected the files of one run", row,
                                   inputs.filename().string()));
    ++row;
  }
  if (row < rows.rows())
    throw InputError({.file = table.string(), .line = rows.lines[row]},
                     fmt::format("{} holds {} frames, the table {}: expected the files of one run",
                                 inputs.filename().string(), row, rows.rows()));
  return row;
}

}  // namespace forefeel
