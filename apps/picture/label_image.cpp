#include "apps/picture/label_image.hpp"

#include <algorithm>
#include <utility>

namespace forefeel {

std::vector<LabelBox> label_runs(const LabelImage& image, int row, int longest) {
  std::vector<LabelBox> runs;
  for (int column = 0; column < image.columns; ++column) {
    const Label label = image.at(column, row);
    if (runs.empty() || runs.back().label != label || column - runs.back().left == longest)
      runs.push_back({column, column, row, row + 1, label});
    runs.back().right = column + 1;
  }
  return runs;
}

std::vector<LabelBox> label_boxes(const LabelImage& image) {
  std::vector<LabelBox> boxes, open;
  for (int row = 0; row <= image.rows; ++row) {
    std::vector<LabelBox> next;
    if (row < image.rows) next = label_runs(image, row, image.columns);
    for (LabelBox& box : open) {
      const auto same = std::ranges::find_if(next, [&](const LabelBox& run) {
        return run.left == box.left && run.right == box.right && run.label == box.label;
      });
      box.above = row;
      if (same == next.end())
        boxes.push_back(box);
      else
        same->below = box.below;
    }
    open = std::move(next);
  }
  return boxes;
}

}  // namespace forefeel
