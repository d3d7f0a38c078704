#include "apps/python/arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel::python {
namespace {

std::string shape_of(const py::array& array) {
  std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
  return fmt::format("({})", fmt::join(shape, ", "));
}

void expect(bool fits, const py::array& array, const char* argument, const char* expected) {
  if (!fits)
    throw InputError(argument, fmt::format("has the shape {}, expected {}", shape_of(array), expected));
}

}  // namespace

void register_state_dtype() {
  PYBIND11_NUMPY_DTYPE(StateRow, at, site, force, stiffness, energy, spacing, residual, seconds, min_jacobian,
                       iterations, status, multivalued);
}

Points::Points(const Doubles& array, const char* argument) : data_(array.data()) {
  const bool one = array.ndim() == 1 && array.shape(0) == 3;
  expect(one || (array.ndim() == 2 && array.shape(1) == 3), array, argument, "(n, 3)");
  size_ = one ? 1 : static_cast<std::size_t>(array.shape(0));
  std::size_t wrong = size_;
  {
    const py::gil_scoped_release released;
#pragma omp parallel for schedule(static) reduction(min : wrong) if (size_ > 100'000)
    for (std::size_t i = 0; i < size_; ++i)
      if (!(*this)[i].allFinite()) wrong = std::min(wrong, i);
  }
  if (wrong < size_)
    throw InputError(argument, fmt::format("row {} (from 0) is not finite, expected three numbers", wrong));
}

std::vector<Vec3> points_of(const Doubles& array, const char* argument) {
  const Points points(array, argument);
  std::vector<Vec3> copy(points.size());
  for (std::size_t i = 0; i < copy.size(); ++i) copy[i] = points[i];
  return copy;
}

py::array_t<double> array_of(std::span<const Vec3> points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* to = out.mutable_data();
  for (std::size_t i = 0; i < points.size(); ++i) std::copy_n(points[i].data(), 3, to + 3 * i);
  return out;
}

py::array_t<double> array_of(const Vec3& vector) {
  return py::array_t<double>(3, vector.data());
}

py::array_t<double> array_of(const Box& box) {
  const Vec3 corners[] = {box.low, box.high};
  return array_of(corners);
}

void check_spacing(double spacing) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw InputError("spacing", fmt::format("is {} m, expected a positive number", spacing));
}

py::array_t<StateRow> array_of(std::span<const State> states) {
  py::array_t<StateRow> out = zero_rows<StateRow>(states.size());
  StateRow* to = out.mutable_data();
  for (const State& s : states) {
    StateRow& row = *to++;
    std::copy_n(s.at.data(), 3, row.at);
    std::copy_n(s.site.data(), 3, row.site);
    std::copy_n(s.force.data(), 3, row.force);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) row.stiffness[i][j] = s.stiffness(i, j);
    row.energy = s.energy, row.spacing = s.spacing, row.residual = s.solve.residual,
    row.seconds = s.solve.seconds;
    row.min_jacobian = s.solve.min_jacobian, row.iterations = s.solve.iterations;
    row.status = static_cast<std::uint8_t>(s.solve.status), row.multivalued = s.solve.multivalued;
  }
  return out;
}

py::list jets_of(std::span<const State> states) {
  py::list jets;
  for (const State& state : states) {
    if (!state.jet) {
      jets.append(py::none());
      continue;
    }
    py::dict jet;
    for (std::size_t i = 0; i < jet_terms_of_order(state.jet->order); ++i)
      jet[py::str(jet_names()[i])] = state.jet->coefficients[i];
    jet["limit"] = state.jet->limit;
    jets.append(std::move(jet));
  }
  return jets;
}

std::vector<State> states_of(const py::array_t<StateRow>& rows) {
  std::vector<State> states(static_cast<std::size_t>(rows.size()));
  const StateRow* from = rows.data();
  for (State& s : states) {
    const StateRow& row = *from++;
    s.at = Vec3(row.at[0], row.at[1], row.at[2]);
    s.site = Vec3(row.site[0], row.site[1], row.site[2]);
    s.force = Vec3(row.force[0], row.force[1], row.force[2]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) s.stiffness(i, j) = row.stiffness[i][j];
    s.energy = row.energy, s.spacing = row.spacing, s.solve.residual = row.residual,
    s.solve.seconds = row.seconds;
    s.solve.min_jacobian = row.min_jacobian, s.solve.iterations = row.iterations;
    s.solve.status = static_cast<SolveStatus>(row.status), s.solve.multivalued = row.multivalued;
  }
  return states;
}

std::vector<State> states_of(const Doubles& positions, const Doubles& forces,
                             const std::optional<Doubles>& stiffness) {
  const std::vector<Vec3> at = points_of(positions, "positions"), force = points_of(forces, "forces");
  if (force.size() != at.size())
    throw InputError("forces",
                     fmt::format("has {} rows, expected as many as positions, {}", force.size(), at.size()));
  if (stiffness)
    expect(stiffness->ndim() == 3 && stiffness->shape(0) == static_cast<py::ssize_t>(at.size()) &&
               stiffness->shape(1) == 3 && stiffness->shape(2) == 3,
           *stiffness, "stiffness", "(n, 3, 3)");
  std::vector<State> states(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    states[i].at = at[i];
    states[i].force = force[i];
    for (int r = 0; stiffness && r < 3; ++r)
      for (int c = 0; c < 3; ++c) states[i].stiffness(r, c) = stiffness->at(i, r, c);
  }
  return states;
}

}  // namespace forefeel::python
