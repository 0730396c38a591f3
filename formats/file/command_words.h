// The words of a command line, read by CLI11 in the same way by every program.
#pragma once

#include <algorithm>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/result.h"
#include "common/text.h"
#include "formats/file/standard_streams.h"

namespace tremolo {

// Makes empty values an error for all options: an unset variable in a script gives an empty value,
// which is a mistake and not the same as no option.
inline void refuse_empty_values(CLI::App& app) {
  for (CLI::Option* option : app.get_options())
    if (option->get_items_expected_max() > 0)
      option->check(CLI::Validator(
          [](std::string& text) { return std::string(text.empty() ? "its value is empty" : ""); },
          ""));
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
    refuse_empty_values(*command);
}

// The first word of the form --flag=, for which CLI11 would take the next word as the value; empty:
// there is none. Words after -- are ignored.
inline std::string flag_without_value(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "--") break;
    if (word.starts_with("--") && word.find('=') == word.size() - 1) return word;
  }
  return {};
}

// An error in the words that CLI11 does not report, or not well; empty: CLI11 checks the rest.
inline std::string problem_of_words(const CLI::App& app, const std::vector<std::string>& words) {
  if (const std::string flag = flag_without_value(words); !flag.empty())
    return flag + " has no value";
  if (app.get_require_subcommand_min() == 0 || words.empty() || words[0].starts_with('-'))
    return {};
  std::string names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == words[0]) return {};
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  return "there is no command `" + words[0] + "`: there are " + names;
}

// Reads the words, without the program's name, into the variables of the app's options. Returns the
// exit code if the program must end: after --help and --version 0, or 1 if standard output cannot
// be written; that of wrong usage after a message.
inline std::optional<int> read_words(CLI::App& app, const std::vector<std::string>& words) {
  const auto wrong = [&app](const std::string& what) {
    std::cerr << app.get_name() << ": " << printable(what) << " (--help lists the options)\n";
    return exit_code(ErrorKind::kUsage);
  };
  if (const std::string problem = problem_of_words(app, words); !problem.empty())
    return wrong(problem);
  refuse_empty_values(app);
  try {
    std::vector<std::string> reversed(words.rbegin(), words.rend());
    app.parse(reversed);
    return std::nullopt;
  } catch (const CLI::ExtrasError&) {
    std::string extra;
    for (const std::string& word : app.remaining(true)) extra += ' ' + word;
    return wrong("not expected:" + extra);
  } catch (const CLI::ParseError& error) {
    if (app.exit(error, std::cout, std::cerr) != 0) return exit_code(ErrorKind::kUsage);
  }
  const Status printed = flush_standard_output();
  if (printed) return 0;
  std::cerr << app.get_name() << ": " << printed.error().message << "\n";
  return exit_code(printed.error());
}

inline std::optional<int> read_words(CLI::App& app, int count, char** words) {
  return read_words(app, std::vector<std::string>(words + std::min(count, 1), words + count));
}

}  // namespace tremolo
