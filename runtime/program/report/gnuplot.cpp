#include "runtime/program/report/gnuplot.h"

#include <csignal>
#include <cstdio>
#include <sys/wait.h>

namespace tremolo {

std::string gnuplot_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += c == '\n' || c == '\r' ? ' ' : c;
  }
  return result + "'";
}

Status run_gnuplot(const std::string& script) {
  // Where gnuplot is missing the shell is gone before it has read: that must not kill us.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::FILE* pipe = ::popen("gnuplot", "w");
  if (pipe == nullptr) {
    std::signal(SIGPIPE, before);
    return system_error("gnuplot cannot be started");
  }
  std::fwrite(script.data(), 1, script.size(), pipe);  // a failure shows in the status
  const int status = ::pclose(pipe);
  std::signal(SIGPIPE, before);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    return system_error("gnuplot is not installed (Debian: apt-get install gnuplot-nox)");
  if (status != 0) return system_error("gnuplot failed");
  return Success{};
}

}  // namespace tremolo
