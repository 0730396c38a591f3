// Starts one of the project's programs and waits for it.
#pragma once

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/wait.h>

#include "tests/support/temporary_folder.h"

namespace tremolo::testing {

struct ProgramResult {
  int code = -1;    // exit code; 128 + n after signal n, as a shell says it
  std::string out;  // stdout
  std::string err;  // stderr
};

inline std::string slurp(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// `command` as a shell would read it.
inline ProgramResult run_program(const std::string& folder, const std::string& command) {
  const std::string out = folder + "/stdout.txt";
  const std::string err = folder + "/stderr.txt";
  const int status = std::system(
      ("cd '" + folder + "' && " + command + " >'" + out + "' 2>'" + err + "'").c_str());
  ProgramResult result;
  result.code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  result.out = slurp(out);
  result.err = slurp(err);
  return result;
}

}  // namespace tremolo::testing
