#!/usr/bin/env bash
# Installs what is missing, checks the format, builds the tests and runs them; ends at the first part that is red. Safe
# to repeat.
#   run.sh           the fast tests, those that a change may break: each takes at most 10 s. Of a folder in which no
#                    object changed since they were green, none is run
#   run.sh --fresh   the fast tests of all folders
#   run.sh all       all tests, the slow ones too, with all that they compare with (over a gigabyte to install)
set -euo pipefail
cd "$(dirname "$0")/.."
build=build/release
case "${1:-}" in
  "" | --fresh) bash apps/setup.sh tests; targets=(forefeel_fast_tests) ;;
  all) bash apps/setup.sh all; targets=(all forefeel_installable forefeel_bench) ;;
  *) echo "run.sh: '$1' is unknown, expected all, --fresh or nothing" >&2; exit 2 ;;
esac

# The formatter's version is part of the rule: other versions break lines elsewhere.
git ls-files -z --cached --others --exclude-standard '*.cpp' '*.hpp' | xargs -0 clang-format-14 --dry-run --Werror
cmake --preset release
cmake --build --preset release --target "${targets[@]}"

# A digest of what the fast tests of a folder run: its objects and those below it, and the files that they read. The
# object with the commit's name stands for its source.
digest_of() {
  local -A below=([geometry]=geometry [solver]="geometry solver" [approx]="geometry solver approx"
                  [scheduling]="geometry solver approx scheduling")
  local rooms=${below[$1]:-geometry solver approx scheduling apps} kept='^(tests/CMakeLists.txt|tests/support/|apps/console/provenance.cpp)'
  case $1 in
    apps | fuzz) kept="$kept|^apps/.*\\.(toml|py|js|css|html|txt|in)$|^apps/examples/|^tests/$1/.*\\.(py|txt)$" ;;
    house) kept='' ;;
    scheduling) kept="$kept|^tests/scheduling/|^(geometry|solver|approx|scheduling)/" ;;   # a test reads the sources
    *) kept="$kept|^tests/$1/.*\\.(py|txt)$" ;;
  esac
  { for room in $rooms "tests/$1" tests/CMakeFiles; do find "$build/$room" -name '*.o' ! -name 'provenance*'; done
    git ls-files --cached --others --exclude-standard | grep -E "$kept"; } |
    LC_ALL=C sort -u | tr '\n' '\0' | { xargs -0 sha256sum 2>/dev/null || true; } | sha256sum
}

mkdir -p "$build/green"
folders=()
declare -A digests
for folder in geometry solver approx scheduling apps house fuzz; do
  digests[$folder]=$(digest_of "$folder")   # before the tests: what is edited meanwhile is not green
  if [ "${1:-}" = "" ] && [ "$(cat "$build/green/$folder" 2>/dev/null)" = "${digests[$folder]}" ]; then
    echo "$folder: unchanged since its fast tests were green"
  else
    folders+=("$folder")
  fi
done
if [ ${#folders[@]} -gt 0 ]; then
  ctest --preset release --parallel "$(nproc)" --no-tests=error -L fast -R "^($(IFS='|'; echo "${folders[*]}"))/"
  for folder in "${folders[@]}"; do echo "${digests[$folder]}" >"$build/green/$folder"; done
fi
if [ "${1:-}" = all ]; then
  ctest --preset release --parallel "$(nproc)" --no-tests=error -L slow --stop-on-failure
else
  echo "Left out: $(ctest --preset release -N -L slow | sed -n 's/^Total Tests: //p') entries of slow tests, whose sources say why they are slow. All: bash tests/run.sh all"
fi
