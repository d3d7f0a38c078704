#!/usr/bin/env bash
# Builds and runs the whole suite, the command line included, under sanitizers; ends with 1 where a test fails or a
# sanitizer finds something. Takes long: a build of its own for each.
#   sanitize.sh           both
#   sanitize.sh asan      address and undefined behaviour (GCC)
#   sanitize.sh tsan      threads (clang, libomp with Archer)
#   sanitize.sh tsan REGEX …   further words go to ctest: sanitize.sh tsan -R scheduling/
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-}" in
  "") kinds=(asan tsan) ;;
  asan | tsan) kinds=("$1"); shift ;;
  *) echo "sanitize.sh: '$1' is unknown, expected asan, tsan or nothing" >&2; exit 2 ;;
esac

bash apps/setup.sh all
bad=0
for kind in "${kinds[@]}"; do
  reports=$PWD/build/$kind/reports
  cmake --preset "$kind"
  cmake --build --preset "$kind"
  rm -rf "$reports"; mkdir -p "$reports"
  # Reports go to files as well: a command that a test runs prints them where nobody looks.
  export FOREFEEL_SANITIZER="log_path=$reports/report"   # CMakePresets.json adds it to the sanitizer's options
  ctest --preset "$kind" --parallel "$(nproc)" --timeout 3600 "$@" || bad=1
  found=$(find "$reports" -type f | wc -l)
  echo "$kind: $found processes with a report in $reports"
  [ "$found" -eq 0 ] || bad=1
done
exit "$bad"
