#pragma once
// A picture of filled polygons and texts, written as SVG, or as PNG through gnuplot. Both draw the same shapes in
// the same order, so the two look alike; lines and dots are narrow polygons.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace forefeel {

using Vec2 = Eigen::Vector2d;  // [pixels], y downwards

class FlatPicture {
 public:
  FlatPicture(int width, int height) : width_(width), height_(height) {}

  void polygon(std::vector<Vec2> corners, const std::string& colour, double opacity = 1);
  void line(const Vec2& from, const Vec2& to, double width, const std::string& colour, double opacity = 1);
  void dot(const Vec2& at, double radius, const std::string& colour, double opacity = 1);
  void text(const Vec2& at, const std::string& words, int size = 13, const std::string& colour = "#1b1b1b");

  std::size_t polygons() const { return polygons_.size(); }
  std::string svg(const std::string& title) const;
  std::optional<std::string> png() const;  // nothing if gnuplot is missing or fails

 private:
  struct Polygon {
    std::vector<Vec2> corners;
    std::string colour;
    double opacity;
  };
  struct Text {
    Vec2 at;
    std::string words;
    int size;
    std::string colour;
  };

  int width_, height_;
  std::vector<Polygon> polygons_;
  std::vector<Text> texts_;
};

}  // namespace forefeel
