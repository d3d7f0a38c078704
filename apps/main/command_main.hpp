#pragma once
// The command `forefeel` as a function, for a program that adds parts of its own to it:
//
//   #include <forefeel/command.hpp>   // find_package(forefeel COMPONENTS command), target forefeel::command
//
//   int main(int argc, char** argv) {
//     forefeel::register_policy("mine", …);      // likewise predictors, devices, costs and workers
//     return forefeel::command_main(argc, argv);
//   }
//
// The program has all commands of forefeel. Its scenes, studies and options know the registered names.
// A complete program: apps/examples/command_policy.cpp.

namespace forefeel {

// Runs `forefeel argv[1] …`, prints to stdout and stderr, and returns the exit code: 0 done; 1 ran, but the
// answer is negative or incomplete; 2 bad input. Throws nothing. Call it once, from main(): it handles SIGINT
// and SIGTERM.
int command_main(int argc, char** argv);

}  // namespace forefeel
