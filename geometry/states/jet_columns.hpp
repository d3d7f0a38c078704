#pragma once
// A jet as cells of a table: columns e300 … e005 (jet_names()) and limit [m]. Coefficients above the jet's order are
// unknown; without any there is no jet. Private to this room.

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

struct JetCells {
  std::array<double, jet_size> coefficients;  // NaN: unknown
  double limit;                               // [m]; infinite: none; NaN: unknown
};

struct JetOfCells {
  std::shared_ptr<const EnergyJet>
      jet;              // its order is the highest whose coefficients are all known; may be null
  std::string problem;  // why the cells are no jet, with the column; empty if they are fine
};
JetOfCells jet_of(const JetCells& cells);
JetCells cells_of(const EnergyJet* jet);  // of a null pointer: all unknown

const std::vector<std::string>& jet_columns();  // the names of the coefficients, then "limit"
// The columns of a table must be those of whole degrees: "no column e102, expected …", or empty.
std::string missing_jet_column(const std::function<bool(const std::string& column)>& has);

}  // namespace forefeel
