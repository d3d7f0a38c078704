#!/usr/bin/env bash
# Fuzzes every reader with libFuzzer, address and undefined-behaviour sanitizers:
#   bash tests/fuzz.sh [SECONDS] [TARGET …]
# SECONDS (60) for each target, as many side by side as there are processors. Inputs that crash are kept in
# build/fuzz/crashes; the corpus in build/fuzz/corpus grows with each run.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
bash apps/setup.sh sanitizers   # clang with libFuzzer
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --target test_fuzz fuzzers
folder=$PWD/build/fuzz
mkdir -p "$folder/crashes" "$folder/logs"
FOREFEEL_SEEDS=$folder/corpus "$folder/tests/fuzz/test_fuzz" '[.seeds]' >/dev/null
targets=("$@")
[ $# -gt 0 ] || mapfile -t targets < <(ls "$folder/corpus")

fuzz() {
  mkdir -p "$3/crashes/$1"
  "$3/tests/fuzz/fuzz_$1" -max_total_time="$2" -timeout=10 -rss_limit_mb=3000 -max_len=20000 -print_final_stats=1 \
    -artifact_prefix="$3/crashes/$1/" "$3/corpus/$1" >"$3/logs/$1" 2>&1 && result=ok || result=FAILED
  echo "$1: $result, $(sed -n 's/stat::number_of_executed_units: *//p' "$3/logs/$1") executions"
  [ $result = ok ]
}
export -f fuzz
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c "fuzz {} $seconds '$folder'"
