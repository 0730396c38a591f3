// The standard streams of a program: what it does with them first and last.
#pragma once

#include <iostream>

#include "common/result.h"

namespace tremolo {

// Opens what is closed of descriptors 0, 1 and 2 on /dev/null, so that no file takes its number: an
// output opened as descriptor 2 would get the words meant for stderr. It is opened the wrong way
// round: who reads or writes there gets an error (a result that nobody can take is exit code 1).
// For the first line of a program that was perhaps started with `2>&-`; a library must not call it.
void hold_standard_streams();

// Sends on what std::cout and stdout still hold. kSystem: somebody could not take a part of what
// was printed, and the program must not end with 0.
Status flush_standard_output();

// One object of nlohmann's as every program writes it: indented by two, text that is no UTF-8
// replaced, a line's end behind it.
template <class Json>
std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// The same on standard output; flush_standard_output() tells whether it has arrived.
template <class Json>
void print_json(const Json& json) {
  std::cout << json_text(json);
}

}  // namespace tremolo
