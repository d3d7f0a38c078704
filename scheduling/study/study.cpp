#include "scheduling/study/study.hpp"

#include <map>

namespace forefeel {

std::size_t Study::combinations() const {
  std::size_t n = 1;
  for (const StudyAxis& axis : axes) n *= axis.values.size();
  return n;
}

std::vector<std::size_t> Study::choice(std::size_t combination) const {
  std::vector<std::size_t> chosen(axes.size());
  for (std::size_t i = axes.size(); i-- > 0;) {
    chosen[i] = combination % axes[i].values.size();
    combination /= axes[i].values.size();
  }
  return chosen;
}

std::optional<std::size_t> find_axis(const Study& study, std::string_view column) {
  for (std::size_t i = 0; i < study.axes.size(); ++i)
    if (study.axes[i].column == column) return i;
  return {};
}

std::optional<double> number_at(const Study& study, const std::vector<std::size_t>& choice,
                                std::string_view column) {
  const std::optional<std::size_t> axis = find_axis(study, column);
  return axis ? study.axes[*axis].values[choice[*axis]].number : std::nullopt;
}

bool is_trace_axis(const StudyAxis& axis) {
  return axis.column == "device" || axis.column == "session.device";
}

std::vector<std::size_t> blocks_without(const Study& study, std::size_t axis) {
  std::map<std::vector<std::size_t>, std::size_t> numbers;
  std::vector<std::size_t> blocks;
  for (std::size_t c = 0; c < study.combinations(); ++c)
    for (std::size_t s = 0; s < study.seeds.size(); ++s) {
      std::vector<std::size_t> rest = study.choice(c);
      rest[axis] = 0;
      rest.push_back(s);
      blocks.push_back(numbers.try_emplace(rest, numbers.size()).first->second);
    }
  return blocks;
}

}  // namespace forefeel
