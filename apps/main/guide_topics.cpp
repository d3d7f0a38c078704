// Topics of `forefeel help` that are about ideas, not about a file: the labels, and the words of reports. A topic of
// more than a table is added here, and to help_topics().

#include "apps/main/help_topics.hpp"

namespace forefeel {

HelpTopic labels_topic() {
  return {
      "labels",
      "How well the force is known at a place: the first of four labels whose rule holds. h is the spacing, "
      "state_space.spacing: the distance between states at which you call the space densely known.",
      {{"label",
        "Try forefeel classify points.csv -o coverage.svg; all four: forefeel classify setup:gap.",
        {{"safe", "", "",
          "states within 1.45 h on all sides, and a spread of at most 0.95 h: densely known; it says nothing "
          "of stability"},
         {"sparse", "", "", "the nearest state is within 1.5 h"},
         {"gap", "", "",
          "states within 8 h on all sides, no empty cone above 85 degrees: a bridge between known regions"},
         {"blank", "", "", "beyond the known regions: the force is extrapolated"}}},
       {"index",
        "The numbers behind the labels, in coverage.csv (forefeel help outputs coverage.csv).",
        {{"spread", "m", "",
          "of the Delaunay cell of states that holds the place: sqrt(R^2 - d^2), for the radius R and the "
          "distance d from the centre of its circumsphere; safe up to 0.95 h"},
         {"alpha", "m", "", "least such radius R of the cells at the place"},
         {"delta", "m", "", "distance to the nearest state"},
         {"gamma", "degrees", "", "half-angle of the largest cone of directions without a state"}}},
       {"where",
        "Keys, commands and columns that deal with labels.",
        {{"forefeel classify", "", "", "labels of given states, as numbers, picture or volume"},
         {"state_space.spacing", "", "", "h, in a scene; forefeel help scene state_space"},
         {"frames.csv label", "", "", "of the tip, each frame; forefeel help outputs frames.csv"},
         {"session.policy", "", "", "what is solved next; forefeel help devices policy"}}}}};
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
  static const std::map<std::string, std::string> aliases{{"label", "labels"}, {"coverage", "labels"},
                                                          {"report", "words"}, {"glossary", "words"},
                                                          {"keys", "scene"},   {"columns", "outputs"}};
  return aliases;
}

}  // namespace forefeel
