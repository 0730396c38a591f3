// Checks of numbers on the command line, with messages that name the expected and the actual value.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "common/processor.h"
#include "common/result.h"

namespace tremolo {

// Accepts numbers for which good(number) is true. expected: for the message.
template <class Number, class Good>
CLI::Validator number_check(const std::string& expected, const Good& good) {
  return CLI::Validator(
      [expected, good](std::string& text) -> std::string {
        Number value{};
        const char* end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (error == std::errc{} && stop == end && good(value)) return "";
        return "expected " + expected + ", found " + text;
      },
      "");
}

// Accepts finite numbers above zero.
inline CLI::Validator above_zero() {
  return number_check<double>("a number above 0",
                              [](double value) { return std::isfinite(value) && value > 0; });
}

// Accepts integers from one to `most`.
inline CLI::Validator at_least_one(int most = std::numeric_limits<int>::max()) {
  return number_check<int>("a whole number from 1 to " + std::to_string(most),
                           [most](int value) { return value >= 1 && value <= most; });
}

// Accepts a number of bytes with or without a unit, as "500MB", and replaces it by the number.
inline CLI::Validator byte_count() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const std::string given = text;
        try {
          std::uint64_t value = 0;
          if (CLI::AsSizeValue(true)(text).empty() &&
              std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc{} &&
              value > 0)
            return "";
        } catch (const CLI::Error&) {
        }
        return "expected a whole number of bytes above 0, as 4GB or 500MB, found " + given;
      },
      "BYTES");
}

// The words of a command line that decide what the file of a `command` holds: the same work gives
// the same text wherever the file goes.
inline std::string settings_text(const std::string& command, int count, char** words) {
  std::string settings = command;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == "-o" || word == "--output" || word == "--threads")
      ++i;  // and its value
    else if (word != "--json" && !word.starts_with("--output=") && !word.starts_with("--threads="))
      settings += " " + word;
  }
  return settings;
}

// Returns the error message on one line.
inline std::string one_line_message(const CLI::App* app, const CLI::Error& error) {
  return app->get_name() + ": " + error.what() + " (--help lists the options)\n";
}

// Accepts numbers of threads.
inline CLI::Validator thread_count() {
  return at_least_one(static_cast<int>(kMostThreads));
}

}  // namespace tremolo
