#pragma once

#include <cerrno>
#include <cstring>
#include <string>

#include "common/result.h"

namespace tremolo {

// The error of the last failed system call, from errno: "WHAT: why". ENOMEM has the message of
// every other lack of memory.
inline Error os_error(const std::string& what) {
  const int number = errno;
  return system_error(what + ": " + (number == ENOMEM ? "out of memory" : std::strerror(number)));
}

}  // namespace tremolo
