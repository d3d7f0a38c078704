#pragma once
// A still picture of what `forefeel show` shows, seen from the side of the contact: body, box, a cut plane through
// the labels, states, path of the hand with forces, and a legend.

#include "apps/show/flat_picture.hpp"
#include "apps/show/show_content.hpp"

namespace forefeel {

FlatPicture still_picture(const ShowContent& content);

}  // namespace forefeel
