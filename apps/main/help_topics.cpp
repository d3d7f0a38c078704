#include "apps/main/help_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/console/outputs.hpp"
#include "apps/picture/page.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/spec_text.hpp"
#include "apps/study/study_file.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/record/shape_files.hpp"
#include "scheduling/study/cell_result.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {
namespace {

HelpTopic scene_topic() {
  return {"scene", "The scene file (TOML). Unknown keys are errors; --set table.key=value overrides one.",
          scene_tables()};
}

HelpTopic study_topic() {
  return {"study", "The study file (TOML): sessions for every combination of values, compared.",
          study_tables(), guide_study};
}

// Recordings of people, none of them part of Forefeel.
DeclaredTable recordings() {
  return {
      "recordings",
      "Public recordings of hands, with the text that reads each as a device. `forefeel trace FILE,SETTINGS "
      "--to-contact -o t.csv` checks one, shifts it to the contact, cuts it (--from, --to) and writes "
      "t,x,y,z; "
      "\"trace:traces/*.csv\" in a study takes all of a folder.",
      {{"JIGSAWS", "", "",
        "Gao, Vedula, Reiley et al., JHU-ISI gesture and skill assessment working set, M2CAI 2014: eight "
        "surgeons at a da Vinci console; cirl.lcsr.jhu.edu/research/hmm/datasets/jigsaws_release, on "
        "request, "
        "for research. 76 columns, 30 Hz, m. Right hand: trace:Suturing_B001.txt,columns=20/21/22,rate=30; "
        "right "
        "tool: columns=58/59/60"},
       {"Auslan", "", "",
        "Kadous, Australian sign language signs (high quality), UCI data set 115, 2002: 2565 signs of one "
        "signer, 0.6 s each; archive.ics.uci.edu/dataset/115, CC BY 4.0. 22 columns, about 100 Hz, m. Right "
        "hand: trace:alive-1.tsd,columns=12/13/14,rate=100"},
       {"WAY-EEG-GAL", "", "",
        "Luciw, Jarocka, Edin, Scientific Data 1:140047, 2014 (doi 10.1038/sdata.2014.47): twelve people "
        "reach, "
        "grasp and lift; doi 10.6084/m9.figshare.988376, CC BY. Wrist, 500 Hz, cm: python3 -c \"import "
        "scipy.io as s, numpy as n; k = s.loadmat('HS_P1_S1.mat', simplify_cells=True)['hs']['kin']; c = "
        "list(k['names']); n.savetxt('p1.csv', k['sig'][:, [c.index(a) for a in ('Px4', 'Py4', 'Pz4')]], "
        "delimiter=',')\", then trace:p1.csv,columns=1/2/3,rate=500,unit=cm"},
       {"LASA", "", "",
        "Khansari-Zadeh, Billard, handwriting dataset, IEEE T-RO 27, 2011: 30 shapes drawn seven times with "
        "a "
        "pen; bitbucket.org/khansari/lasahandwritingdataset, for research, cite the paper. Plane, mm: "
        "python3 -c "
        "\"import scipy.io as s, numpy as n; d = s.loadmat('Angle.mat', simplify_cells=True)['demos'][0]; "
        "n.savetxt('a.csv', n.c_[d['t'], d['pos'].T], delimiter=',')\", then "
        "trace:a.csv,columns=1/2/3/-,unit=mm"},
       {"Quick, Draw!", "", "",
        "Google, 2017: 50 million drawings by mouse and finger; "
        "github.com/googlecreativelab/quickdraw-dataset, "
        "CC BY 4.0. Raw files, plane, pixels and ms: python3 -c \"import json; [print(t, x, y, sep=',') for "
        "s in "
        "json.loads(open('cat.ndjson').readline())['drawing'] for x, y, t in zip(*s)]\" > cat.csv, then "
        "trace:cat.csv,columns=1/2/3/-,unit=mm/ms with a scale, as the size of a pixel is unknown"}}};
}

HelpTopic devices_topic() {
  HelpTopic topic{
      "devices",
      "The texts of --device, --cost, --policy, --predictor and --workers-kind, and of their keys.",
      device_tables()};
  topic.tables.push_back(cost_table());
  topic.tables.push_back({"policy", "--policy or session.policy: what is solved next.", declared_policies()});
  topic.tables.push_back(
      {"predictor", "--predictor or session.predictor: where the hand will be.", declared_predictors()});
  DeclaredTable workers{"workers", "--workers-kind or session.workers_kind: who solves.", {}};
  for (const std::string& name : workers_names())
    workers.rows.push_back({name, "", "",
                            name == "threads" ? "threads of this process; simulated under the virtual clock"
                                              : "registered by this program"});
  topic.tables.push_back(workers);
  topic.tables.push_back(recordings());
  return topic;
}

// The tables of the files that forefeel writes.
HelpTopic outputs_topic() {
  HelpTopic topic{
      "outputs", "The files of a run, of a study, and of single commands. Unknown values are empty, or null.",
      declared_run_files()};
  topic.tables.push_back(
      {"session.inputs",
       "All that came into a run, in binary: states, times, positions. forefeel replay RUN "
       "renders it again and compares each force.",
       {}});
  topic.tables.push_back({"states.csv", "States of a run, of solve, export and import.", declared_states()});
  topic.tables.push_back(declared_shape_table());
  for (const DeclaredTable& table :
       {summary_output(), info_scene_output(), cells_output(), forces_output(), coverage_output(),
        left_out_output(), solve_output(), mesh_output(), generate_output(), generate_sites_output(),
        placement_output(), evaluate_output(), evaluate_sites_output(), sited_forces_output(),
        classify_sites_output(), labelled_sites_output(), classify_output()})
    topic.tables.push_back(table);
  return topic;
}

// The words of a text in lines of at most `width`; the first line begins at `used` already.
std::string wrapped(const std::string& text, std::size_t used, std::size_t indent, std::size_t width) {
  std::istringstream words(text);
  std::string out;
  bool first = true;
  for (std::string word; words >> word; first = false) {
    if (!first && used + 1 + word.size() > width) {
      out += "\n" + std::string(indent, ' ');
      used = indent;
    } else if (!first) {
      out += ' ';
      ++used;
    }
    out += word;
    used += word.size();
  }
  return out;
}

std::string left_of(const Declared& row) {
  return row.name + (row.unit.empty() || row.unit == "1" ? "" : " [" + row.unit + "]");
}

std::string right_of(const Declared& row) {
  if (row.standard.empty()) return row.meaning;
  const bool words = row.standard.starts_with("required");
  return row.meaning + (words ? "; " : "; default ") + row.standard;
}

std::string html_of(const DeclaredTable& table, const std::string& topic) {
  const bool with_defaults =
      std::ranges::any_of(table.rows, [](const Declared& row) { return !row.standard.empty(); });
  const bool with_units =
      std::ranges::any_of(table.rows, [](const Declared& row) { return !row.unit.empty(); });
  std::string html = fmt::format("<h3 id=\"{0}-{1}\">{1}</h3>\n<p class=\"muted\">{2}</p>\n",
                                 html_escaped(topic), html_escaped(table.name), html_escaped(table.meaning));
  if (table.rows.empty()) return html;
  html += fmt::format("<table><tr><th>name</th>{}{}<th>meaning</th></tr>\n",
                      with_units ? "<th>unit</th>" : "", with_defaults ? "<th>default</th>" : "");
  for (const Declared& row : table.rows) {
    std::string name = html_escaped(row.name);
    for (std::size_t at = 0; (at = name.find(',', at)) != std::string::npos; at += 6)
      name.insert(at + 1, "<wbr>");
    html += "<tr><td><code>" + name + "</code></td>";
    if (with_units) html += "<td>" + html_escaped(row.unit) + "</td>";
    if (with_defaults) html += "<td>" + html_escaped(row.standard) + "</td>";
    html += "<td>" + html_escaped(row.meaning) + "</td></tr>\n";
  }
  return html + "</table>\n";
}

}  // namespace

std::vector<HelpTopic> help_topics() {
  std::vector<HelpTopic> topics{scene_topic(), study_topic(), devices_topic(), outputs_topic()};
  for (HelpTopic& page : guide_topics()) topics.push_back(std::move(page));
  topics.push_back(words_topic());
  return topics;
}

std::vector<DeclaredTable> tables_named(const HelpTopic& topic, const std::string& name) {
  std::vector<DeclaredTable> found;
  std::ranges::copy_if(topic.tables, std::back_inserter(found), [&](const DeclaredTable& table) {
    return table.name == name || table.name.starts_with(name + ".");
  });
  return found;
}

std::string as_text(const DeclaredTable& table, std::size_t width) {
  std::string text = table.name + "\n  " + wrapped(table.meaning, 2, 2, width) + "\n";
  std::size_t column = 12;
  for (const Declared& row : table.rows)
    column = std::max(column, std::min<std::size_t>(left_of(row).size() + 4, 34));
  for (const Declared& row : table.rows) {
    const std::string left = left_of(row);
    text += "  " + left;
    if (left.size() + 4 > column)
      text += "\n" + std::string(column, ' ');
    else
      text += std::string(column - left.size() - 2, ' ');
    text += wrapped(right_of(row), column, column, width) + "\n";
  }
  return text;
}

std::string as_html(const std::string& program, const std::vector<HelpTopic>& topics) {
  std::string html = "<h1>" + program +
                     ": reference</h1>\n<p class=\"sub\">Every key, setting and column. SI units; [1]: a "
                     "share or a ratio.</p>\n";
  for (const HelpTopic& topic : topics) {
    html += fmt::format("<p><b>{}</b>:", html_escaped(topic.name));
    for (const DeclaredTable& table : topic.tables)
      html +=
          fmt::format(" <a href=\"#{0}-{1}\">{1}</a>", html_escaped(topic.name), html_escaped(table.name));
    html += "</p>\n";
  }
  for (const HelpTopic& topic : topics) {
    html += fmt::format("<h2>{}</h2>\n<p>{}</p>\n", html_escaped(topic.name), html_escaped(topic.meaning));
    if (!topic.page.empty()) html += "<pre>" + html_escaped(std::string(topic.page)) + "</pre>\n";
    for (const DeclaredTable& table : topic.tables) html += html_of(table, topic.name);
  }
  return html_page(program + ": reference", html);
}

nlohmann::ordered_json to_json(const std::vector<HelpTopic>& topics) {
  nlohmann::ordered_json document;
  document["topics"] = nlohmann::ordered_json::array();
  for (const HelpTopic& topic : topics) {
    nlohmann::ordered_json tables = nlohmann::ordered_json::array();
    for (const DeclaredTable& table : topic.tables) {
      nlohmann::ordered_json rows = nlohmann::ordered_json::array();
      for (const Declared& row : table.rows)
        rows.push_back(
            {{"name", row.name}, {"unit", row.unit}, {"default", row.standard}, {"meaning", row.meaning}});
      tables.push_back({{"name", table.name}, {"meaning", table.meaning}, {"rows", rows}});
    }
    document["topics"].push_back({{"topic", topic.name}, {"meaning", topic.meaning}, {"tables", tables}});
    if (!topic.page.empty()) document["topics"].back()["page"] = std::string(topic.page);
  }
  return document;
}

}  // namespace forefeel
