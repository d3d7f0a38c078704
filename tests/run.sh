#!/usr/bin/env bash
# Installs what is missing, builds Release with all tests, and runs them all. Safe to repeat.
set -euo pipefail
cd "$(dirname "$0")/.."

bash apps/setup.sh tests
cmake --preset release
cmake --build --preset release
ctest --preset release --parallel "$(nproc)"
