#pragma once
// Scripts, styles and other texts of HTML pages. They are files of this folder tree; the build puts them into the
// executable (apps/CMakeLists.txt).

#include <string_view>

namespace forefeel {

extern const std::string_view page_style;  // of every page (page.hpp)
extern const std::string_view
    run_script;  // of a session's report: reads the document of run_data.hpp from the element
                 // "run-data", draws into the elements that run_charts.hpp makes
extern const std::string_view shape_script;  // of the shapes in it

// The viewer of `forefeel show`, and the scripts of three.js that it uses: empty if the build did not find them.
extern const std::string_view viewer_script, viewer_style, viewer_body;
extern const std::string_view three_script, orbit_script, three_licence;

}  // namespace forefeel
