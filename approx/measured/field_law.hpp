#pragma once
// The law of the field of measured forces (gaussian_process.hpp): its kind, length, amplitude and noise.
//
// Of each kind (Gaussian, Matern's with 5/2 and 3/2), the likeliest law is sought among some clusters of neighbouring
// rows, near ones for the noise and far ones for the length, and improved with more of them. Of up to 440 rows the
// likeliest kind is taken. More rows tell more: each law is improved with up to 1,200 of them, and compared by how well
// it predicts left-out rows (left_out_scores()): the likeliest kind gives way to one that surely predicts single rows
// better, and that one to another that surely predicts groups of rows better. A Gaussian law with noise is often the
// likeliest of a force with a kink; it is then wrong at the kink, and sure.
//
// Where there are many rows, the mean of a box of neighbouring rows stands for them: its noise is less by the square
// root of their number, and lines that are dense along themselves weigh no more than their length. Boxes are made only
// where the field bends less within a box than the noise of its mean; else the rows nearest to a place serve, thinned
// where they lie on lines or in heaps, so that they are of several of these. Of heaps (geometry/states/heaps.hpp) few
// rows count wherever rows are counted.
//
// S [N/m]: the largest secant |F_i - F_j| / |x_i - x_j| of neighbouring boxes, or the largest force over half the
// extent of the rows, if that is more.
//
// A law is one for all places, but a force may be rough in some of them. local_field() seeks the law of Matern's kind
// with 3/2 anew among the rows nearest to each place. What it costs is a few milliseconds a place.

#include <cstddef>
#include <optional>
#include <span>

#include "approx/measured/gaussian_process.hpp"
#include "approx/measured/thin_plate.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// The likeliest law of the forces of the states, and S. Nothing for fewer than 8 states or states at one place.
std::optional<FieldOptions> field_of(std::span<const State> states, const KnownNoise& noise = {});

// Whether both give the same forces; of one set of states.
inline bool same_process(const FieldOptions& a, const FieldOptions& b) {
  return a.neighbours == b.neighbours && a.local == b.local && a.spline.amplitude == b.spline.amplitude;
}

// The field whose law is sought anew among the rows nearest to each place: for a force that is rough in some places.
// Nothing for fewer rows than four times those of a place.
std::optional<FieldOptions> local_field(const FieldOptions& field, std::size_t rows);

// Means of boxes of at most `size` neighbouring states.
MeasuredRows averaged_boxes(std::span<const State> states, std::size_t size);

// The rows at A x (FieldOptions::stretch).
MeasuredRows stretched(MeasuredRows rows, const Mat3& by);

}  // namespace forefeel
