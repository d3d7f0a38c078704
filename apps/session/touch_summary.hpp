#pragma once
// summary.json of a session with contact.anywhere.

#include <string>
#include <vector>

#include "apps/console/document_keys.hpp"
#include "scheduling/record/control_summary.hpp"
#include "scheduling/session/session_options.hpp"
#include "scheduling/touch/touch_result.hpp"

namespace forefeel {

struct TouchErrors {
  std::size_t samples = 0;
  double p50 = unknown, p95 = unknown, max = unknown;
  double within_jnd = unknown;  // share of the samples [1]
};

// Of the error bars of one level, at samples.
struct TouchBars {
  double inside = unknown, inside_above = unknown;  // share of samples; of those above the floor of the bars
  std::size_t at_floor = 0;                         // samples
  double width = unknown;                           // median half-width [N]
};

struct TouchSummary {
  struct Settings {
    std::string device, clock, policy, predictor;
    int workers = 0;
    double seconds = 0, depth = 0, site_spacing = 0;
    std::optional<double> friction;
  };
  struct Field {
    std::size_t sites = 0;
    double seconds = 0, patches = 0;  // [s]
    bool kept = false;
  };
  struct Touches {
    std::size_t count = 0;                      // that began
    double time = unknown, slipping = unknown;  // shares of the time; slipping of the time in touch
    double slid = 0, lost = 0, stored = 0;      // [m], [J], the most that was stored [J]
    double cone = unknown;                      // |(|g| / f . n) - mu| / mu while sliding, the largest
    std::vector<double> angle;                  // of f to the normal: p50, p95 [rad]
  };
  struct States {
    std::size_t start = 0, jets = 0, solved = 0, failed = 0, preempted = 0;
  };
  struct Switching {
    std::size_t count = 0, over_bound = 0;
    double max_jump = 0;  // undamped [N]
  };
  Settings settings;
  Field field;
  Touches touch;
  States states;
  ByLabel<double> time_in;  // shares of the time in touch
  double time_trusted = unknown;
  TouchErrors samples, first_visit, trusted, untrusted;
  std::array<TouchBars, 3> bars;  // of 90, 95 and 99 %
  std::size_t references_failed = 0;
  Switching switching;
  SafetyReport safety;
  ControlSummary control;
  std::vector<double> cost_us;  // of a frame: p50, p99; real clock only
  std::size_t frames = 0, skipped = 0;
  bool interrupted = false;
  std::vector<std::string> notes;
};

TouchSummary summarise_touch(const TouchSessionResult& result, const TouchSessionInput& input,
                             const SessionOptions& options);
const JsonKeys<TouchSummary>& touch_summary_keys();

}  // namespace forefeel
