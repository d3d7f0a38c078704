// Topics of `forefeel help` that are about ideas, not about a file: the pages of the guide, and the words of reports.

#include "apps/main/help_topics.hpp"
#include "apps/picture/page.hpp"

namespace forefeel {

std::vector<HelpTopic> guide_topics() {
  return {{"labels", "Where is the force known? Labels, own points, own meshes.", {}, guide_labels},
          {"bodies", "Exact forces: bodies, pads, fine bodies, energy jets, hard cases.", {}, guide_bodies},
          {"models", "The force between states: models, measured forces, error bars.", {}, guide_models},
          {"report", "Reading a report, Python, clusters, figures, the paper.", {}, guide_report}};
}

HelpTopic words_topic() {
  return {
      "words",
      "The words of summaries and reports.",
      {{"session",
        "Of a session's report.html and summary.",
        {{"state", "", "", "a solved equilibrium: force and stiffness at one position of the tip"},
         {"sample", "", "", "a frame whose force was also solved tightly, to know its error"},
         {"first visit", "", "", "the first frame of the tip in a cell of the lattice of states"},
         {"error", "", "", "of the rendered force against the tight solve, relative"},
         {"tight solve", "", "",
          "a solve that is far more exact than needed to render: the reference of the errors"},
         {"reference branch", "", "", "the equilibria that the body reaches straight from rest"},
         {"JND", "", "", "just noticeable difference: a change of force below it is not felt (7 %)"},
         {"rendered, sent", "", "",
          "the force of the model; the force that the device got, after limits on force and slew"},
         {"approximation, switch, staleness", "", "",
          "parts of the error: too few states; still on the way to the newest model; states not yet used"},
         {"clamped, slewed", "", "", "frames whose force was cut at its limit, or at its rate of change"},
         {"load", "1", "", "states that the motion needs / states that the workers solve; not a force"},
         {"felt step", "", "", "a jump of the force that a hand feels and did not cause"},
         {"error bar", "", "", "the true force lies within it with 90, 95 or 99 %"},
         {"audit", "", "", "a solve where the tip had just been, to check the error bars"},
         {"trusted", "", "", "inside the distance to which an energy jet was not contradicted"},
         {"wasted", "", "", "solved states that no model used"},
         {"inverted", "", "", "a solve that turned elements inside out; it does not count"}}},
       {"study",
        "Of a study's report.html and table.",
        {{"target_load", "1", "",
          "load that is asked for: 1, the workers just keep up with the hand; 2, they solve half of what "
          "it needs"},
         {"clairvoyant", "", "", "an upper bound: it knows the motion beforehand"},
         {"regret", "1", "", "what a policy lacks to the clairvoyant one, which is the upper bound"},
         {"pair", "", "", "two sessions that differ in one thing: the same motion and seed"}}}}};
}

const std::map<std::string, std::string>& help_aliases() {
  static const std::map<std::string, std::string> aliases{
      {"label", "labels"},    {"coverage", "labels"}, {"points", "labels"},  {"meshes", "labels"},
      {"body", "bodies"},     {"pads", "bodies"},     {"jets", "bodies"},    {"model", "models"},
      {"bars", "models"},     {"measured", "models"}, {"policies", "study"}, {"sessions", "study"},
      {"studies", "study"},   {"reports", "report"},  {"python", "report"},  {"pandas", "report"},
      {"clusters", "report"}, {"paper", "report"},    {"glossary", "words"}, {"keys", "scene"},
      {"columns", "outputs"}};
  return aliases;
}

}  // namespace forefeel
