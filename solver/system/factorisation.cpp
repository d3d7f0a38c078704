#include "solver/system/factorisation.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <type_traits>
#include <variant>

#include "solver/system/factor_layout.hpp"
#include "solver/system/share_out.hpp"

namespace forefeel {
namespace {

std::int64_t padding_of(Precision precision) {
  return precision == Precision::exact ? row_padding<double> : row_padding<float>;
}

// That of the discretisation if it fits.
std::shared_ptr<const FactorLayout> make_layout(const Discretisation& d, Precision precision) {
  const std::int64_t padding = padding_of(precision);
  if (d.layout && d.layout->size.padding == padding) return d.layout;
  return std::make_shared<const FactorLayout>(d.pattern, d.free_nodes, padding);
}

const FactorKernels<double>& kernels_of(const double*) {
  return front_kernels().exact;
}
const FactorKernels<float>& kernels_of(const float*) {
  return front_kernels().single;
}

constexpr double flops_of_a_part = 4e5;  // some 15 microseconds
constexpr std::int64_t most_parts = 16;
constexpr std::size_t most_fields = 3;  // solved at once

// 0 to `count` in ranges for threads to share, in multiples of `unit`, as many as the work is worth.
struct Ranges {
  std::int64_t count, each;

  Ranges(std::int64_t entries, std::int64_t unit, double flops) : count(entries) {
    const auto wanted =
        std::clamp(static_cast<std::int64_t>(flops / flops_of_a_part), std::int64_t{1}, most_parts);
    each = std::max<std::int64_t>(1, (count + wanted * unit - 1) / (wanted * unit)) * unit;
  }
  void share(const std::function<void(Part)>& part) const {
    share_out(static_cast<std::size_t>((count + each - 1) / each), [&](std::size_t i) {
      const std::int64_t first = static_cast<std::int64_t>(i) * each;
      part({first, std::min(each, count - first)});
    });
  }
};

// The numbers of a factor, and the vectors that are solved with it.
template <class Real>
struct Numbers {
  const FactorLayout& layout;
  const FactorKernels<Real>& kernels = kernels_of(static_cast<const Real*>(nullptr));
  std::vector<Real> panels, stack;
  mutable std::vector<Real> work, vectors;

  explicit Numbers(const FactorLayout& its_layout)
      : layout(its_layout),
        panels(layout.panels()),
        stack(layout.stacks()),
        work(most_fields * lane_count * static_cast<std::size_t>(layout.size.work)) {}

  bool compute(const double* blocks, double* corner) {
    if (!(layout.top.empty() ? factor(layout.parts.front(), blocks, stack.data()) : compute_shared(blocks)))
      return false;
    std::copy_n(blocks + 9 * layout.row_start[static_cast<std::size_t>(layout.size.free_nodes)], 9, corner);
    for (const Front& front : layout.top.empty() ? layout.fronts : layout.fronts_of_top)
      for (std::int64_t i = 0; front.parent < 0 && front.rest > 0 && i < 9; ++i) {
        const std::int64_t a = std::min(i / 3, i % 3), b = std::max(i / 3, i % 3);
        corner[i] +=
            static_cast<double>(stack[static_cast<std::size_t>(front.update + a * front.update_ld + b)]);
      }
    for (std::int64_t a = 0; a < 3; ++a)
      for (std::int64_t b = 0; b < a; ++b) corner[3 * a + b] = corner[3 * b + a];
    return true;
  }

  // b: `fields` times local vectors, `count` of them side by side, `stride` numbers apart
  void solve(double* b, int count, std::size_t fields = 1, std::int64_t stride = 0) const {
    std::array<Real*, most_fields> v{};
    if (!in_place()) vectors.resize(std::max(vectors.size(), fields * rows(count)));
    for (std::size_t f = 0; f < fields; ++f)
      v[f] = taken(b + static_cast<std::int64_t>(f) * stride, count, f);
    upwards({v.data(), fields}, count);
    downwards({v.data(), fields}, count);
    for (std::size_t f = 0; f < fields; ++f) give(v[f], b + static_cast<std::int64_t>(f) * stride, count);
  }
  void half_solve_lanes(double* b) const {
    if (!in_place()) vectors.resize(std::max(vectors.size(), rows(lane_count)));
    Real* v = taken(b, lane_count, 0);
    upwards({&v, 1}, lane_count);
    give(v, b, lane_count);
  }
  void tangent(double* v) const {
    const auto n = static_cast<std::size_t>(3 * layout.size.free_nodes);
    vectors.assign(rows(lane_count), Real(0));
    for (std::size_t c = 0; c < 3; ++c) vectors[(n + c) * lane_count + c] = 1;
    Real* const all = vectors.data();
    downwards({&all, 1}, lane_count);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < n + 6; ++i)
        v[c * (n + 6) + i] = i < n + 3 ? static_cast<double>(vectors[i * lane_count + c]) : 0.0;
  }

 private:
  bool factor(const FactorLayout::Subtree& part, const double* blocks, Real* updates) {
    return kernels.factor(layout.tree(), part.fronts, blocks, panels.data(), updates);
  }
  bool compute_shared(const double* blocks) {
    std::atomic<bool> positive = true;
    share_out(layout.parts.size(), [&](std::size_t i) {
      const FactorLayout::Subtree& part = layout.parts[i];
      static thread_local std::vector<Real> scratch;
      scratch.resize(std::max(scratch.size(), layout.scratches()));
      if (!factor(part, blocks, scratch.data())) positive = false;
      const Front& root = layout.root(part);
      for (std::int64_t row = 0; row < 3 * std::int64_t{root.rest}; ++row)  // the upper triangle
        std::copy_n(scratch.data() + root.update + row * root.update_ld + row, root.update_ld - row,
                    stack.data() + part.kept + row * root.update_ld + row);
    });
    const FrontTree tree = layout.tree_of_top();
    for (const std::int64_t s : layout.top)
      if (!positive || !share_front(tree, tree.fronts[s], blocks)) return false;
    return positive;
  }
  // A front of the top, in steps.
  bool share_front(const FrontTree& tree, const Front& front, const double* blocks) {
    Real *panel = panels.data() + front.panel, *update = stack.data() + front.update;
    const std::int64_t pivots = 3 * std::int64_t{front.pivots}, all = pivots + 3 * std::int64_t{front.rest};
    const double width = static_cast<double>(all);
    Ranges(all, 3, 8 * width * width).share([&](Part rows) {
      kernels.assemble(tree, front, rows, blocks, panels.data(), stack.data());
    });
    for (std::int64_t first = 0; first < pivots; first += kernels.block_rows) {
      const Part block{first, std::min(kernels.block_rows, pivots - first)};
      if (!kernels.eliminate_diagonal(front, block, panel)) return false;
      const std::int64_t end = first + block.count,
                         from = (end + layout.size.padding - 1) / layout.size.padding * layout.size.padding;
      const double deep = static_cast<double>(block.count), right = static_cast<double>(front.ld - from);
      if (from < front.ld)
        Ranges(front.ld - from, layout.size.padding, 0.5 * deep * deep * right).share([&](Part columns) {
          kernels.eliminate_columns(front, block, {from + columns.first, columns.count}, panel);
        });
      // rows of a triangle: the first are the longest
      if (end < all)
        Ranges(all - end, row_unit, 0.5 * deep * right * right).share([&](Part rows) {
          kernels.update(front, block, {end + rows.first, rows.count}, panel, update);
        });
    }
    return true;
  }

  static constexpr std::int64_t row_unit = 24;

  std::size_t rows(int count) const {  // of v: free nodes, contact and tails
    return static_cast<std::size_t>(3 * (layout.size.free_nodes + 1 + layout.size.tails) * count);
  }
  using Fields = std::span<Real* const>;
  Real* work_of(std::int64_t offset, std::size_t field) const {
    return work.data() + (static_cast<std::int64_t>(field) * layout.size.work + offset) * lane_count;
  }

  // Rows of the nodes that a part meets, between the vector and the part's tail.
  template <class Move>
  void each_met(int count, Real* v, const Move& move) const {
    for (const FactorLayout::Subtree& part : layout.parts)
      for (std::int64_t i = 0; i < part.nodes.count; ++i) {
        Real* in_tail = v + 3 * count * (part.tail + i);
        Real* in_vector = v + 3 * count * layout.met[static_cast<std::size_t>(part.nodes.first + i)];
        for (int k = 0; k < 3 * count; ++k) move(in_tail[k], in_vector[k]);
      }
  }
  void clear_behind(Real* v, int count) const {  // the contact and the tails
    const auto first = static_cast<std::size_t>(3 * layout.size.free_nodes * count);
    std::fill(v + first, v + rows(count), Real(0));
  }
  template <class Run>
  void run_parts(Fields v, const Run& run) const {
    const FrontTree tree = layout.tree();
    share_out(layout.parts.size() * v.size(), [&](std::size_t i) {
      const std::size_t field = i % v.size();
      const FactorLayout::Subtree& part = layout.parts[i / v.size()];
      run(tree, part.fronts, panels.data(), v[field], work_of(part.work, field));
    });
  }
  void upwards(Fields v, int count) const {
    const FrontTree tree = layout.tree();
    const auto run = count == 1 ? kernels.forward : kernels.forward_lanes;
    for (Real* const one : v) clear_behind(one, count);
    run_parts(v, run);
    share_out(v.size(), [&](std::size_t i) {
      each_met(count, v[i], [](Real& tail, Real& row) { row += tail; });
      for (const std::int64_t s : layout.top)
        run(tree, {s, 1}, panels.data(), v[i], work_of(layout.size.top_work, i));
      std::fill_n(v[i] + 3 * layout.size.free_nodes * count, 3 * count, Real(0));  // the contact
    });
  }
  void downwards(Fields v, int count) const {
    const FrontTree tree = layout.tree();
    const auto run = count == 1 ? kernels.backward : kernels.backward_lanes;
    share_out(v.size(), [&](std::size_t i) {
      for (std::size_t s = layout.top.size(); s-- > 0;)
        run(tree, {layout.top[s], 1}, panels.data(), v[i], work_of(layout.size.top_work, i));
      each_met(count, v[i], [](Real& tail, Real& row) { tail = row; });
    });
    run_parts(v, run);
  }

  bool in_place() const { return std::is_same_v<Real, double> && layout.size.tails == 0; }
  Real* taken(double* b, int count, std::size_t field) const {
    if constexpr (std::is_same_v<Real, double>)
      if (in_place()) return b;
    Real* const v = vectors.data() + field * rows(count);
    std::copy_n(b, 3 * layout.size.free_nodes * count, v);
    return v;
  }
  void give(const Real* v, double* b, int count) const {
    if (!in_place()) std::copy_n(v, 3 * (layout.size.free_nodes + 1) * count, b);
  }
};

}  // namespace

struct Factorisation::Impl {
  std::shared_ptr<const FactorLayout> layout;
  std::variant<Numbers<double>, Numbers<float>> numbers;
  double corner[9] = {};

  Impl(const Discretisation& d, Precision precision)
      : layout(make_layout(d, precision)), numbers(make_numbers(*layout, precision)) {}

  static std::variant<Numbers<double>, Numbers<float>> make_numbers(const FactorLayout& layout,
                                                                    Precision precision) {
    if (precision == Precision::exact) return Numbers<double>(layout);
    return Numbers<float>(layout);
  }
};

Factorisation::Factorisation(const Discretisation& discretisation, Precision precision)
    : impl_(std::make_unique<Impl>(discretisation, precision)) {}
Factorisation::~Factorisation() = default;
Factorisation::Factorisation(Factorisation&&) noexcept = default;

Precision Factorisation::precision() const {
  return impl_->numbers.index() == 0 ? Precision::exact : Precision::single;
}

bool Factorisation::compute(const double* blocks) {
  Impl& f = *impl_;
  return std::visit([&](auto& n) { return n.compute(blocks, f.corner); }, f.numbers);
}

void Factorisation::solve(double* b) const {
  std::visit([&](const auto& n) { n.solve(b, 1); }, impl_->numbers);
}

void Factorisation::solve_lanes(double* b, std::size_t fields, std::int64_t stride) const {
  std::visit([&](const auto& n) { n.solve(b, lane_count, fields, stride); }, impl_->numbers);
}

void Factorisation::half_solve_lanes(double* b) const {
  std::visit([&](const auto& n) { n.half_solve_lanes(b); }, impl_->numbers);
}

Mat3 Factorisation::stiffness() const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(impl_->corner);
}

void Factorisation::tangent(double* v) const {
  std::visit([&](const auto& n) { n.tangent(v); }, impl_->numbers);
}

std::shared_ptr<const Discretisation> analyse(const Body& body, Precision precision) {
  auto made = std::make_shared<Discretisation>(discretise(body));
  made->layout = make_layout(*made, precision);
  return made;
}

FactorCost cost_of_factor(const Discretisation& discretisation) {
  const FactorLayout& l = *discretisation.layout;
  const auto bytes = l.size.padding == padding_of(Precision::single) ? sizeof(float) : sizeof(double);
  return {l.size.flops, static_cast<std::int64_t>(bytes * l.panels()),
          static_cast<std::int64_t>(bytes * l.stacks())};
}

}  // namespace forefeel
