#include "geometry/mesh/gmsh_scanner.hpp"

#include <unordered_map>

namespace forefeel {

GmshElement gmsh_element(std::int64_t type) {
  static const std::unordered_map<std::int64_t, GmshElement> known{
      {1, {2, 1}},   {2, {3, 2}},   {3, {4, 2}},   {4, {4, 3}},   {5, {8, 3}},   {6, {6, 3}},   {7, {5, 3}},
      {8, {3, 1}},   {9, {6, 2}},   {10, {9, 2}},  {11, {10, 3}}, {12, {27, 3}}, {13, {18, 3}}, {14, {14, 3}},
      {15, {1, 0}},  {16, {8, 2}},  {17, {20, 3}}, {18, {15, 3}}, {19, {13, 3}}, {20, {9, 2}},  {21, {10, 2}},
      {22, {12, 2}}, {23, {15, 2}}, {24, {15, 2}}, {25, {21, 2}}, {26, {4, 1}},  {27, {5, 1}},  {28, {6, 1}},
      {29, {20, 3}}, {30, {35, 3}}, {31, {56, 3}}, {92, {64, 3}}, {93, {125, 3}}};
  const auto found = known.find(type);
  return found == known.end() ? GmshElement{0, 0} : found->second;
}

const char* gmsh_element_name(std::int64_t type) {
  switch (type) {
    case 5:
    case 12:
    case 17:
    case 92:
    case 93:
      return "hexahedra";
    case 6:
    case 13:
    case 18:
      return "prisms";
    case 7:
    case 14:
    case 19:
      return "pyramids";
    default:
      return "tetrahedra of higher order than the second";
  }
}

}  // namespace forefeel
