#pragma once
// NumPy arrays from and to the library's types. Arrays are C-ordered; lengths [m], forces [N],
// stiffness [N/m].

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/types.hpp"
#include "geometry/states/state.hpp"

// Docstrings call an array of rows numpy.ndarray; its C++ type means nothing to a reader of Python.
namespace pybind11::detail {
template <class Row>
requires std::is_class_v<Row>
struct handle_type_name<array_t<Row, array::forcecast>> {
  static constexpr auto name = const_name("numpy.ndarray");
};
}  // namespace pybind11::detail

namespace forefeel::python {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// One row of a structured array of states; the fields of State (geometry/states/state.hpp).
struct StateRow {
  double at[3], site[3], force[3], stiffness[3][3];  // site: NaN without one
  double energy, spacing, residual, seconds, min_jacobian;
  std::int32_t iterations;
  std::uint8_t status;  // index in status_names
  bool multivalued;
};
void register_state_dtype();

// n rows of zeros. The bytes between the fields are zero too, so that equal rows are equal as bytes.
template <class Row>
py::array_t<Row> zero_rows(std::size_t n) {
  py::array_t<Row> rows(static_cast<py::ssize_t>(n));
  std::memset(static_cast<void*>(rows.mutable_data()), 0, n * sizeof(Row));
  return rows;
}

// (n, 3), or (3,) for one point. InputError names the argument if the shape differs or a value is not finite.
std::vector<Vec3> points_of(const Doubles& array, const char* argument);
py::array_t<double> array_of(std::span<const Vec3> points);  // (n, 3)
py::array_t<double> array_of(const Vec3& vector);            // (3,)
py::array_t<double> array_of(const Box& box);                // (2, 3): low corner, high corner

// The same, without a copy: valid while the array lives. Checked in parallel.
class Points {
 public:
  Points(const Doubles& array, const char* argument);
  std::size_t size() const { return size_; }
  Vec3 operator[](std::size_t i) const { return Eigen::Map<const Vec3>(data_ + 3 * i); }

 private:
  const double* data_;
  std::size_t size_;
};

// A value as T. InputError names the argument and the type that is expected.
template <class T>
T cast_to(const py::handle& value, const std::string& argument, const char* expected) {
  try {
    return py::cast<T>(value);
  } catch (const py::cast_error&) {
    throw InputError(argument, "is " + std::string(py::repr(value)).substr(0, 60) + ", expected " + expected);
  }
}

// The choice of this name. InputError names the argument and lists the names.
template <class Choices>
auto chosen(const std::string& text, const char* argument, const Choices& all) {
  std::string names;
  for (const auto choice : all) {
    if (name(choice) == text) return choice;
    names += (names.empty() ? "" : ", ") + std::string(name(choice));
  }
  throw InputError(argument, fmt::format("is '{:.40}', expected {}", text, names));
}

// InputError unless the spacing is positive and finite.
void check_spacing(double spacing);

py::array_t<StateRow> array_of(std::span<const State> states);
// For each state its energy jet, a dict {"e300": …, "limit": …} with the coefficients of its order, or None.
py::list jets_of(std::span<const State> states);
// Usable and failed states as they are. Displacements and jets are not part of the array.
std::vector<State> states_of(const py::array_t<StateRow>& rows);
// Measured states. forces: (n, 3); stiffness: (n, 3, 3), or none.
std::vector<State> states_of(const Doubles& positions, const Doubles& forces,
                             const std::optional<Doubles>& stiffness);

}  // namespace forefeel::python
