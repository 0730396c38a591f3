// What the user is told while the program works: on stderr.
#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "common/result.h"

namespace tremolo {

// Like fmt::print(stderr, ...), which throws where nobody can hear it. A stderr that is full or
// closed loses the words and nothing else: results and exit code are the same.
template <class... Values>
void tell(fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = fmt::format(format, std::forward<Values>(values)...);
  std::fputs(text.c_str(), stderr);
}

// "tremolo: message" on stderr; the error's exit code.
inline int report_error(const Error& error) {
  tell("tremolo: {}\n", error.message);
  return exit_code(error);
}

}  // namespace tremolo
