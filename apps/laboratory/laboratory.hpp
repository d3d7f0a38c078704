#pragma once
// What the commands that make experiments of their own share (`reproduce`, `bench switch`, the calibration of
// labels): a scene or the built-in one, states that stay on disk from run to run, tables and pictures.

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/scene_input/scene.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {

// share in [0, 1] and what is being done.
using ShowShare = std::function<void(double, const std::string&)>;

class Laboratory {
 public:
  // scene: a file, or "" for the built-in one. Overrides of the scene and warnings are taken from and given
  // to globals.
  Laboratory(const Globals& globals, const std::string& scene);

  const Scene& scene() const { return scene_; }
  const Globals& globals() const { return globals_; }
  std::string name() const { return scene_.file.string(); }
  bool built_in() const { return built_in_; }              // then there is no such file
  double spacing() const { return scene_.space.spacing; }  // h [m]

  // The states of the lattice {k h}^3 in the box that can be solved, to 1e-9 of the force, by growing
  // distance from rest. Solved at most once: a file in the cache folder keeps them, and one that was cut
  // short is filled up.
  std::vector<State> lattice_states(const Box& box, double h, const ShowShare& show = {});
  // Tight solves on the reference branch, in the order of the positions; also kept. Where the body has no
  // solution the state is not usable().
  std::vector<State> references(std::span<const Vec3> at, const ShowShare& show = {});
  const std::shared_ptr<ReferenceService>& service();

  SessionInput session_input() const;  // of the scene, with no known states

 private:
  const Globals& globals_;
  Scene scene_;
  bool built_in_ = false;
  std::shared_ptr<ReferenceService> service_;
};

// Which lattice axes a path runs along: first the one nearest to `inward`, signed; a signed permutation, so
// that it takes lattices to lattices. Columns are the images of x, y, z.
Mat3 lattice_frame(const Vec3& inward);

// p50, p95 and max as an object.
nlohmann::ordered_json quantiles_json(const std::vector<double>& values);

// A file that appears whole or not at all.
void write_text(const std::filesystem::path& file, const std::string& text);

// Pictures: the style that all share, eight colours told apart by every kind of colour vision (Okabe, Ito
// 2008).
extern const char* const plot_style;
const char* line_colour(std::size_t index);

// One experiment's part of a page.
struct Picture {
  std::string name;  // of its file, without ending
  std::string caption;
  int width = 960, height = 420;
  std::string script;  // gnuplot, see plot.hpp
};
// <figure> with the picture in it, and NAME.svg in the folder; a note where gnuplot is missing.
std::string draw_into(const std::filesystem::path& folder, const Picture& picture);
// Rows of cells, the first being the heads; text is escaped here.
std::string html_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace forefeel
