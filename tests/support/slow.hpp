#pragma once
// A test that takes seconds says why:
//
//   TEST_CASE("meshes converge", "[error]" SLOW("solves four meshes")) { … }
//
// Such tests run with `bash tests/run.sh all` (ctest -L slow). `test_solver --list-tests [slow]` lists the reasons.

#define SLOW(reason) "[slow][slow: " reason "]"
