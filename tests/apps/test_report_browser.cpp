// Reports in a real browser, where chromium is installed (`apps/setup.sh all`).

#include "tests/support/executable.hpp"

namespace {

// The output of a script run in this page, at this width.
std::string in_browser(const Workshop& shop, const std::string& page, int width, const std::string& script) {
  const std::string html = shop.read(page);
  shop.write("probe.html", html.substr(0, html.rfind("</body>")) +
                               "<script>addEventListener('load', () => {" + "document.title = 'probe ' + (" +
                               script + ");});</script></body></html>");
  return shop
      .shell("chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=2000 --window-size=" +
             std::to_string(width) + ",900 --dump-dom 'file://" + (shop.path() / "probe.html").string() +
             "' 2>/dev/null | grep -o '<title>[^<]*' | head -1")
      .out;
}

}  // namespace

TEST_CASE("a session's report in a browser: its script runs, and nothing is wider than the page",
          SLOW("starts Chromium, which only run.sh all installs")) {
  if (!has_command("chromium")) {
    skip("chromium is not installed");
    return;
  }
  const BeamShop shop;
  shop.run(
      "session beam.toml --clock virtual --seconds 0.5 --cost constant:0.02 --device "
      "path:circle,speed=0.02 -o run --quiet");
  const std::string drawn =
      "document.documentElement.scrollWidth <= innerWidth && "
      "document.getElementById('run-read').textContent.includes('rendered') && "
      "document.getElementById('run-what').textContent.startsWith('Switch')";
  for (const int width : {1280, 800, 500})
    CHECK_THAT(in_browser(shop, "run/report.html", width, drawn), Contains("probe true"));
}

TEST_CASE("a study's report in a browser: no table is cut off by its frame, also with long names of devices",
          SLOW("starts Chromium, which only run.sh all installs")) {
  if (!has_command("chromium")) {
    skip("chromium is not installed");
    return;
  }
  const BeamShop shop("[session]\nseconds = 0.3\ncost = \"constant:0.02\"\n");
  shop.write(
      "study.toml",
      "scene = \"beam.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n"
      "device = [\"path:circle,speed=0.03,amplitude=0.004,tremor=0.0001\", \"path:line,speed=0.03\"]\n");
  shop.run("study study.toml -o out --quiet");
  const std::string whole =
      "document.documentElement.scrollWidth <= innerWidth && document.querySelectorAll('.ranking').length > "
      "0 && "
      "[...document.querySelectorAll('.scroll')].every(e => e.scrollWidth <= e.clientWidth)";
  for (const int width : {1280, 1000, 800})
    CHECK_THAT(in_browser(shop, "out/report.html", width, whole), Contains("probe true"));
}
