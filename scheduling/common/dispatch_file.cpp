#include "scheduling/common/dispatch_file.hpp"

#include <fmt/format.h>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/common/records.hpp"

namespace forefeel {

bool DispatchRow::became_known() const {
  return status == name(DispatchStatus::solved) || status == name(DispatchStatus::arrived);
}

std::vector<DispatchRow> read_dispatch(const std::filesystem::path& file) {
  const CsvText table = CsvText::read(file, "a file of a run");
  for (const char* column : {"x", "y", "z", "finished", "status"})
    if (!table.has(column))
      throw InputError({.file = file.string()},
                       fmt::format("has no column {}, expected the file of a run", column));
  std::vector<DispatchRow> rows;
  rows.reserve(table.rows());
  for (std::size_t i = 0; i < table.rows(); ++i)
    rows.push_back({.at = {table.number(i, "x"), table.number(i, "y"), table.number(i, "z")},
                    .site = {table.number(i, "sx"), table.number(i, "sy"), table.number(i, "sz")},
                    .finished = table.number(i, "finished"),
                    .known = table.number(i, "known"),
                    .status = std::string(table.text(i, "status")),
                    .line = table.line(i)});
  return rows;
}

}  // namespace forefeel
