// Messages to the user on stderr, results on stdout.
#pragma once

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "common/result.h"
#include "common/text.h"
#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"

namespace tremolo {

// Prints to stderr like fmt::print, as printable() has it, but does not throw when stderr is full
// or closed: the text is lost then, and results and exit code stay the same.
template <class... Values>
void tell(fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = printable(fmt::format(format, std::forward<Values>(values)...));
  std::fputs(text.c_str(), stderr);
}

// Prints to stdout, as printable() has it; flushed() says whether it has arrived.
template <class... Values>
void show(fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = printable(fmt::format(format, std::forward<Values>(values)...));
  std::fputs(text.c_str(), stdout);
}

// "tremolo: MESSAGE" on stderr; the error's exit code.
inline int report_error(const Error& error) {
  tell("tremolo: {}\n", error.message);
  return exit_code(error);
}

// Flushes stdout. Returns `code`, or after an error prints that and returns its exit code.
inline int flushed(int code) {
  const Status status = flush_standard_output();
  return status ? code : report_error(status.error());
}

// Runs the work of main() and returns its exit code, or that of an exception, which is reported on
// stderr. Prepares the standard streams and the removal of temporary files first.
template <class Work>
int run_guarded(const Work& work) {
  hold_standard_streams();
  remove_partial_files_on_signals();
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return report_error(system_error("out of memory"));
  } catch (const std::exception& exception) {
    return report_error(system_error(exception.what()));
  }
}

}  // namespace tremolo
