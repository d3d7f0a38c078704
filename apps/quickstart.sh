#!/usr/bin/env bash
# From a fresh clone to a rendered force: installs missing packages, builds, runs the main job (20 s, real clock, no
# state known at the start) and prints where the report is. Safe to repeat.
set -euo pipefail
cd "$(dirname "$0")/.."

bash apps/setup.sh
cmake --preset release
cmake --build --preset release --target forefeel_installable

run=build/quickstart
rm -rf "$run"
build/release/apps/forefeel session apps/scenes/liver.toml -o "$run"
echo
echo "The report is $PWD/$run/report.html: open it in a browser."
