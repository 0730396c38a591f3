#pragma once

#include <cerrno>
#include <cstring>
#include <string>

#include "common/result.h"

namespace tremolo {

// The error of the system call that failed last, read from errno: "WHAT: why". What the system
// itself has no memory or address space for is told in the words that every other lack of memory is
// told in.
inline Error os_error(const std::string& what) {
  const int number = errno;
  return system_error(what + ": " + (number == ENOMEM ? "out of memory" : std::strerror(number)));
}

}  // namespace tremolo
