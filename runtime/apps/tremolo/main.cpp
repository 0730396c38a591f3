// tremolo: inspects basis files, runs models and scenes, exports and plots the results.
#include "runtime/apps/tremolo/command_line.h"

int main(int count, char** words) {
  return tremolo::run_command_line(count, words);
}
