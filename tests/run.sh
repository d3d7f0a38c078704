#!/usr/bin/env bash
# Installs what is missing, checks the format, builds Release with all tests, compiles every file with clang and all
# warnings (preset develop), and runs all tests. Safe to repeat.
set -euo pipefail
cd "$(dirname "$0")/.."

bash apps/setup.sh tests
# The formatter's version is part of the rule: other versions break lines elsewhere.
git ls-files -z '*.cpp' '*.hpp' | xargs -0 clang-format-14 --dry-run --Werror
cmake --preset release
cmake --build --preset release
cmake --preset develop -DCMAKE_CXX_FLAGS_DEBUG=-O0
cmake --build --preset develop --target forefeel_objects
ctest --preset release --parallel "$(nproc)"
