/* For the tests written in C: a function with an `int line` and a label `done` for its cleanup. */
#pragma once

/* Ends the function with the line at which the condition does not hold. */
#define REQUIRE(condition) \
  do {                     \
    if (!(condition)) {    \
      line = __LINE__;     \
      goto done;           \
    }                      \
  } while (0)
