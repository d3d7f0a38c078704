#include "apps/bench/bench_keys.hpp"

namespace forefeel {
namespace {

std::vector<Declared> common_rows() {
  return {{"rows[].name", "", "", "what is measured"},
          {"rows[].baseline", "", "", "what it is compared with, in the same run"},
          {"rows[].ratio", "1", "", "time of the baseline over ours"},
          {"rows[].ours_us", "us", "", "time of ours"},
          {"rows[].baseline_us", "us", "", "time of the baseline"},
          {"rows[].error.p50,p95,max", "1", "", "relative error of ours, or difference of the forces"},
          {"rows[].n", "", "", "number of states or centres"},
          {"rows[].k", "", "", "states replaced at once; null: none"},
          {"rows[].scene", "", "", "measured on"},
          {"rows[].law", "", "", "of its material"},
          {"rows[].elements", "", "", "of its mesh"},
          {"rows[].threads", "", "", "used by both"},
          {"rows[].tolerance", "1", "", "of the solves behind it"},
          {"provenance.KEY", "", "", "program, machine and inputs"}};
}

std::vector<Declared> approx_rows() {
  return {{"instruction_set", "", "", "of the loops"},
          {"rows[].by_refit", "1", "", "share of the updates that were made anew"},
          {"methods[].method", "", "", "bench approx: one row a method and size"},
          {"methods[].n", "", "", "number of centres"},
          {"methods[].refit_us", "us", "", "time of a new model"},
          {"methods[].update_us.KEY", "us", "", "time to replace k states"},
          {"methods[].evaluate_us", "us", "", "time of a force"},
          {"methods[].error.p50,p95,max", "1", "", "inside the states"},
          {"methods[].outside.KEY.p50,p95,max", "1", "", "at this distance outside"},
          {"methods[].states_for_1_percent", "", "", "states that hold 1 %; null: more than were tried"},
          {"methods[].states_for_7_percent", "", "", "that hold 7 %"},
          {"notes", "", "", "list of lines"}};
}

std::vector<Declared> solver_rows() {
  return {{"instruction_set", "", "", "of the loops"},
          {"blas", "", "", "library behind CHOLMOD"},
          {"failed", "", "", "bench solver: solves that failed"},
          {"states_of_the_scene", "", "", "of the whole lattice"},
          {"speedup_over_one_thread", "1", "", "null: not measured"},
          {"errors_drawn", "", "", "states compared with tight solves"},
          {"baseline_states", "", "", "list: states solved by each baseline"},
          {"baseline_iterations", "", "", "mean of CHOLMOD's full Newton"},
          {"baseline_failed", "", "", "solves of baselines that failed"},
          {"peak_bytes", "bytes", "", "largest memory of the process"},
          {"bytes_per_thread", "bytes", "", "of a solving thread"},
          {"cholmod_factor_bytes", "bytes", "", "of the factor of CHOLMOD"},
          {"rows[].ours_bytes,baseline_bytes", "bytes", "", "with --states 1: memory of one state"},
          {"rows[].ours_analysis_us,baseline_analysis_us", "us", "", "with --states 1: symbolic analysis"},
          {"rows[].ours_iterations,baseline_iterations", "", "", "with --states 1: Newton iterations"}};
}

std::vector<Declared> coverage_rows() {
  return {{"agreement[].setup", "", "", "bench coverage: arrangement of the states"},
          {"agreement[].width", "m", "", "of its empty part"},
          {"agreement[].share", "1", "", "share of the volume where Delaunay and octree labels agree"},
          {"agreement[].states", "", "", "in it"}};
}

std::vector<Declared> switch_rows() {
  return {{"instruction_set", "", "", "of the loops"},
          {"rows[].rule", "", "", "bench switch: paper, smooth or none"},
          {"rows[].update_ms", "ms", "", "a new model this often"},
          {"rows[].frames", "", "", "played"},
          {"rows[].frames_over_jnd", "", "", "whose change exceeds the rule's bound"},
          {"rows[].max_jump", "N", "", "largest change in a frame"},
          {"rows[].max_jump_undamped", "N", "", "between two models"},
          {"rows[].drift.ms50,ms100,ms300", "N", "", "change within so many ms"},
          {"rows[].delay.p50_ms,p95_ms,max_ms", "ms", "", "until a new model is fully there"},
          {"rows[].delay.bound_ms", "ms", "", "its bound"},
          {"rows[].delay.most_of_bound", "1", "", "largest delay over its bound"},
          {"rows[].delay.within_bound", "", "", "true: never above it"},
          {"rows[].models_skipped", "", "", "models that a newer one replaced"},
          {"rows[].latest_wins", "", "", "true: the newest model always wins"},
          {"model", "", "", "that is switched"}};
}

std::vector<Declared> loop_rows() {
  return {{"rows[].record", "", "", "bench loop: true: with the record of inputs"},
          {"rows[].seconds", "s", "", "time of the sessions"},
          {"rows[].loop.frames,missed", "", "",
           "frames of the session's loop, and those that missed their deadline"},
          {"rows[].loop.lateness_us.p50,p99,max", "us", "", "of its wake-ups"},
          {"rows[].loop.cost_us.p50,p99,max", "us", "", "of its frames"},
          {"rows[].bare.frames,missed", "", "", "the same of a bare loop at the same time"},
          {"rows[].bare.lateness_us.p50,p99,max", "us", "", "of its wake-ups"},
          {"rows[].bare.cost_us.p50,p99,max", "us", "", "of its frames"},
          {"rows[].missed_difference.per_1000,low,high", "", "",
           "missed frames of a thousand more than the bare loop, with a 95 % interval"},
          {"rows[].missed_difference.within_noise", "", "", "true: the interval contains zero"},
          {"rows[].realtime_priority", "", "", "true: the loops had it"},
          {"rows[].workers.count", "", "", "of the session"},
          {"rows[].workers.busy", "1", "", "share of their time"},
          {"rows[].workers.load_solves", "", "", "solves that kept the machine busy"},
          {"rows[].processors_used", "", "", "on average"},
          {"rows[].states.start,end", "", "", "known"},
          {"rows[].memory.start,end", "bytes", "", "resident"},
          {"rows[].memory.growth_per_s", "bytes/s", "", "median of the runs"},
          {"good", "", "", "true: no fault was found"}};
}

std::vector<Declared> with_common(const std::vector<Declared>& more) {
  std::vector<Declared> rows = common_rows();
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace

std::vector<DeclaredTable> declared_bench_json() {
  return {{"bench_approx.json", "Of bench approx --json.", with_common(approx_rows())},
          {"bench_solver.json", "Of bench solver --json.", with_common(solver_rows())},
          {"bench_coverage.json", "Of bench coverage --json.", with_common(coverage_rows())},
          {"bench_switch.json", "Of bench switch --json.", with_common(switch_rows())},
          {"bench_loop.json", "Of bench loop --json.", with_common(loop_rows())}};
}

}  // namespace forefeel
