#include "geometry/states/jet_columns.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/states/state.hpp"

namespace forefeel {

namespace {

// The lowest order that has the first `count` coefficients.
int order_with(std::size_t count) {
  return count <= jet_terms_of_order(2) ? 2 : count <= jet_terms_of_order(3) ? 3 : 4;
}

}  // namespace

JetOfCells jet_of(const JetCells& cells) {
  std::size_t last = 0;  // up to the last known coefficient
  for (std::size_t i = 0; i < jet_size; ++i)
    if (!std::isnan(cells.coefficients[i])) last = i + 1;
  if (last == 0) return {};
  const int order = order_with(last);
  EnergyJet jet{.order = order, .limit = cells.limit};
  const std::size_t terms = jet_terms_of_order(order);
  for (std::size_t i = 0; i < terms; ++i) {
    const double e = cells.coefficients[i];
    if (std::isnan(e))
      return {{},
              fmt::format("{} of a jet is unknown, expected all from e300 to {}", jet_names()[i],
                          jet_names()[terms - 1])};
    if (!(std::abs(e) <= largest_number))
      return {{}, fmt::format("{} of a jet is above {:g} in size", jet_names()[i], largest_number)};
    jet.coefficients[i] = e;
  }
  if (!(cells.limit >= 0))
    return {{}, fmt::format("limit of a jet is {}, expected a distance [m] or inf", cells.limit)};
  return {std::make_shared<const EnergyJet>(jet), {}};
}

JetCells cells_of(const EnergyJet* jet) {
  JetCells cells;
  cells.coefficients.fill(unknown);
  cells.limit = jet ? jet->limit : unknown;
  const std::size_t terms = jet ? jet_terms_of_order(jet->order) : 0;
  for (std::size_t i = 0; i < terms; ++i) cells.coefficients[i] = jet->coefficients[i];
  return cells;
}

const std::vector<std::string>& jet_columns() {
  static const std::vector<std::string> columns = [] {
    std::vector<std::string> names(jet_names().begin(), jet_names().end());
    names.emplace_back("limit");
    return names;
  }();
  return columns;
}

std::string missing_jet_column(const std::function<bool(const std::string& column)>& has) {
  std::size_t last = 0;  // up to the last column that is there
  for (std::size_t i = 0; i < jet_size; ++i)
    if (has(jet_names()[i])) last = i + 1;
  if (last == 0) return {};
  const std::size_t terms = jet_terms_of_order(order_with(last));
  for (std::size_t i = 0; i < terms; ++i)
    if (!has(jet_names()[i]))
      return fmt::format("no column {}, expected all from e300 to {} or none", jet_names()[i],
                         jet_names()[terms - 1]);
  return has("limit") ? "" : "no column limit, expected it beside those of the jets";
}

}  // namespace forefeel
