#pragma once
// cells.csv: one row a cell, in an order that only the study decides; the same bytes for the same study
// however many threads ran it and however often it was resumed.

#include <string>
#include <vector>

#include "apps/study/study_run.hpp"

namespace forefeel {

// Adds to each cell, where the policy `clairvoyant` is among what varies, its regret: how much less than the
// clairvoyant policy it has in the same cell otherwise. It takes the best schedule of
// those it rehearses, every policy but the placebos: below zero is only the regret of a policy it does not know.
//   regret.within_jnd, regret.first_visit.within_jnd
void add_regret(const Study& study, std::vector<CellColumns>& cells);

// A column for each varied key, seed, then the keys of the cells (all that occur, in order of first
// appearance; those that are varied keys already are not repeated). Unknown values are empty.
std::string cells_csv(const Study& study, const std::vector<CellColumns>& cells);

// NaN where a cell lacks the key or it is no number.
double cell_number(const CellColumns& cell, const std::string& key);

// Cells that differ in nothing but one axis share a block; numbered from 0 in order of appearance.
std::vector<std::size_t> blocks_without(const Study& study, std::size_t axis);

}  // namespace forefeel
