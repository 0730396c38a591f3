// Opening and flushing of a program's standard streams.
#pragma once

#include <iostream>

#include "common/result.h"

namespace tremolo {

// Opens closed descriptors among 0, 1 and 2 on /dev/null, so that no file gets their numbers: an
// output opened as descriptor 2 would receive the messages for stderr. Each is opened in the wrong
// direction, so that reading or writing gives an error (a result that cannot be printed is exit
// code 1). Call it first in a program, which may have been started with `2>&-`; a library must not
// call it.
void hold_standard_streams();

// Flushes std::cout and stdout. kSystem: a part of the output was lost, and the program must not
// return 0.
Status flush_standard_output();

// A JSON object as every program writes it: indented by two, invalid UTF-8 replaced, with a line
// end.
template <class Json>
std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Prints the same on standard output; flush_standard_output() reports errors.
template <class Json>
void print_json(const Json& json) {
  std::cout << json_text(json);
}

}  // namespace tremolo
