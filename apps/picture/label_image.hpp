#pragma once
// Labels of a rectangle of equal pixels, and what pictures draw of them: runs of one label, merged to boxes.

#include <vector>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

struct LabelImage {
  int columns = 0, rows = 0;
  std::vector<Label> label;  // row by row, from below

  template <class LabelAt>
  LabelImage(int wide, int high, LabelAt&& label_at) : columns(wide), rows(high) {
    label.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) label.push_back(label_at(column, row));
  }
  Label at(int column, int row) const { return label[static_cast<std::size_t>(row * columns + column)]; }
};

struct LabelBox {
  int left, right, below, above;  // columns left to right - 1, rows below to above - 1
  Label label;
};

// The runs of one row, none longer than `longest`.
std::vector<LabelBox> label_runs(const LabelImage& image, int row, int longest);
// Boxes that cover the image: runs along rows, merged with equal runs in the rows above.
std::vector<LabelBox> label_boxes(const LabelImage& image);

}  // namespace forefeel
