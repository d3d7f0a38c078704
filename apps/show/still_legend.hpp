#pragma once
// The legend of a still picture: what each colour stands for, with numbers.

#include "apps/show/flat_picture.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

inline constexpr int legend_left = 905;  // its left edge [px]

void add_legend(const ShowContent& content, FlatPicture& picture);

// So many states would hide the labels: then only those near the cut are drawn.
bool near_cut_only(const ShownStates& states);

}  // namespace forefeel
