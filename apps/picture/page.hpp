#pragma once
// Shared by all HTML pages: the style. A page needs no other file.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/utf8.hpp"

namespace forefeel {

// Scripts, styles and other texts of HTML pages. They are files of this folder tree; the build puts them into the
// executable (apps/CMakeLists.txt).

extern const std::string_view page_style;  // of every page
extern const std::string_view
    run_script;  // of a session's report: reads the document of run_charts.hpp from the element
                 // "run-data", draws into the elements that run_charts.hpp makes
extern const std::string_view shape_script;  // of the shapes in it

// The viewer of `forefeel show`, and the scripts of three.js that it uses: empty if the build did not find them.
extern const std::string_view viewer_script, viewer_style, viewer_body;
// Pages of the guide, as they are in the folders that they explain.
extern const std::string_view guide_labels, guide_bodies, guide_models, guide_study, guide_report;
extern const std::string_view three_script, orbit_script, three_licence;

// Values as whole multiples of `scale`, so that two bytes hold each, in base64 for a script.
std::string base64_of_whole(const std::vector<double>& values, double& scale);
// A complete page around `body` (HTML). title is plain text.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace forefeel
