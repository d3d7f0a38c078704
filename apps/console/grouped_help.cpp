#include "apps/console/grouped_help.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

namespace forefeel {
namespace {

class GroupedHelp : public CLI::Formatter {
 public:
  explicit GroupedHelp(const std::map<std::string, std::string>& examples) : examples_(examples) {}

  std::string make_subcommands(const CLI::App* app, CLI::AppFormatMode) const override {
    std::string text, heading;
    for (const CLI::App* sub : app->get_subcommands([](const CLI::App*) { return true; })) {
      if (sub->get_group() != heading) text += end_of(heading) + "\n" + sub->get_group() + ":\n";
      heading = sub->get_group();
      text += make_subcommand(sub);
    }
    return text + end_of(heading);
  }
  std::string make_subcommand(const CLI::App* sub) const override {  // the first sentence alone
    const std::string meaning = sub->get_description();
    std::ostringstream line;
    CLI::detail::format_help(line, sub->get_name(), meaning.substr(0, meaning.find(". ")), column_width_);
    return line.str();
  }

 private:
  std::string end_of(const std::string& heading) const {
    const auto example = examples_.find(heading);
    return example == examples_.end() ? std::string() : "  Example: " + example->second + "\n";
  }

  const std::map<std::string, std::string>& examples_;
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> grouped_help(const std::map<std::string, std::string>& examples) {
  return std::make_shared<GroupedHelp>(examples);
}

}  // namespace forefeel
