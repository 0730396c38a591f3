// tremolo: inspect a basis file, let it vibrate, plot what happened.
#include "runtime/program/command_line.h"

int main(int count, char** words) {
  return tremolo::run_command_line(count, words, nullptr);
}
