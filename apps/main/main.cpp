// The command forefeel.

#include "apps/main/command_main.hpp"

int main(int argc, char** argv) {
  return forefeel::command_main(argc, argv);
}
