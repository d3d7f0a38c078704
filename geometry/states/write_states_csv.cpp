#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/jet_columns.hpp"
#include "geometry/states/named_columns.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

// Writes text in pieces: a million states as one text would take a gigabyte.
class CsvWriter {
 public:
  explicit CsvWriter(const std::filesystem::path& file) : output_(file) {}
  void put(std::string_view text) {
    text_ += text;
    if (text_.size() > (1u << 20)) flush();
  }
  void commit() {
    flush();
    output_.commit();
  }

 private:
  void flush() {
    output_.write(text_);
    text_.clear();
  }
  OutputFile output_;
  std::string text_;
};

// The coefficients that a jet of order `to` has beyond one of order `from`.
template <int from, int to>
Field<State> jet_field(std::string_view unit, std::string_view meaning) {
  static const std::size_t begin = jet_terms_of_order(from), size = jet_terms_of_order(to) - begin;
  static const std::string names =
      fmt::format("{}", fmt::join(std::span(jet_names()).subspan(begin, size), ","));
  return {names, unit, meaning, [](Cells& o, const State& s) {
            const JetCells cells = cells_of(s.jet.get());
            o.vector(std::span(cells.coefficients).subspan(begin, size));
          }};
}

const std::vector<Field<State>>& state_columns() {
  static const std::string stiffness_names = fmt::format("{}", fmt::join(stiffness_columns, ","));
  static const std::vector<Field<State>> columns{
      {"sx,sy,sz", "m", "site of a pad anywhere, in the mesh; where some state has one",
       [](Cells& o, const State& s) { put(o, s.has_site() ? s.site : Vec3(Vec3::Constant(unknown))); }},
      {"x,y,z", "m", "position of the tip, from its rest position",
       [](Cells& o, const State& s) { put(o, s.at); }},
      {"fx,fy,fz", "N", "force of the body on the tip", [](Cells& o, const State& s) { put(o, s.force); }},
      {stiffness_names, "N/m", "stiffness, -d force_i / d x_j, row by row; where some state has it",
       [](Cells& o, const State& s) {
         const Mat3 by_row = s.stiffness.transpose();
         o.vector({by_row.data(), 9});
       }},
      {"h", "m", "spacing of the lattice that the state belongs to; where known",
       [](Cells& o, const State& s) { put(o, s.spacing); }},
      {"energy", "J", "stored energy; where known", [](Cells& o, const State& s) { put(o, s.energy); }},
      jet_field<0, 2>("N/m^2", "energy jet: E = … + sum of e_abc dx^a dy^b dz^c; where some state has one"),
      jet_field<2, 3>("N/m^3", "its fourth degree; empty where it has none"),
      jet_field<3, 4>("N/m^4", "its fifth degree; empty where it has none"),
      {"limit", "m", "distance to which the jet keeps the material within its limit; inf: everywhere",
       [](Cells& o, const State& s) {
         const double limit = cells_of(s.jet.get()).limit;
         if (std::isinf(limit))
           o.word("inf", no_word);
         else
           put(o, limit);
       }}};
  return columns;
}

}  // namespace

std::vector<Declared> declared_states() {
  return declared<State>(state_columns());
}

void write_states_csv(const std::filesystem::path& file, std::span<const State> states) {
  const auto some = [&](auto&& has) {
    return std::ranges::any_of(states, [&](const State& s) { return s.usable() && has(s); });
  };
  const bool with_jet = some([](const State& s) { return s.jet != nullptr; });
  const bool has[] = {some([](const State& s) { return s.has_site(); }),
                      true,
                      some([](const State& s) { return s.force.allFinite(); }),
                      some([](const State& s) { return s.has_stiffness(); }),
                      some([](const State& s) { return std::isfinite(s.spacing); }),
                      some([](const State& s) { return std::isfinite(s.energy); }),
                      with_jet,
                      with_jet,
                      with_jet,
                      with_jet};
  std::vector<Field<State>> columns;
  for (std::size_t i = 0; i < std::size(has); ++i)
    if (has[i]) columns.push_back(state_columns()[i]);
  CsvWriter out(file);
  out.put(header_of<State>(columns));
  for (const State& state : states)
    if (state.usable()) out.put(csv_row<State>(columns, state));
  out.commit();
}

}  // namespace forefeel
