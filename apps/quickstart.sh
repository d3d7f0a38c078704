#!/usr/bin/env bash
# From a fresh clone to a rendered force: installs missing packages, builds, runs the main job (20 s, real clock, no
# state known at the start) and prints where its report and its picture are. Safe to repeat.
set -euo pipefail
cd "$(dirname "$0")/.."

bash apps/setup.sh
cmake --preset release
cmake --build --preset release --target forefeel   # prints how far it is

run=build/quickstart
rm -rf "$run"
build/release/apps/forefeel session apps/scenes/liver.toml -o "$run"
build/release/apps/forefeel show "$run" --quiet -o "$run/show.html"
echo
echo "The report: file://$PWD/$run/report.html"
echo "The picture, to turn and to play: file://$PWD/$run/show.html"
