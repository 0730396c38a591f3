#include "tests/lab/samples/published.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "formats/file/input_file.h"
#include "tests/lab/work/failure.h"

namespace tremolo {
namespace {

std::string read_published(const std::string& path) {
  Result<std::string> text = read_whole_file(path);
  if (text) return std::move(*text);
  Error error = text.error();
  error.message += "; published values are in assets/published of the repository (--published)";
  throw Failure(std::move(error));
}

std::string path_of(const std::string& directory, const std::string& file) {
  return (std::filesystem::path(directory) / file).string();
}

}  // namespace

PublishedTable::PublishedTable(const std::string& directory, const std::string& file,
                               std::string_view columns)
    : text_(read_published(path_of(directory, file))),
      scanner_(text_, path_of(directory, file),
               {.comment = '#', .commas = true, .lines = true, .open_end = false}) {
  scanner_.at_end();  // goes to the first line that is no comment
  TextScanner names(columns, {}, {.commas = true, .open_end = true});
  while (!names.at_end())
    if (!scanner_.expect(names.token())) throw Failure(scanner_.error());
}

bool PublishedTable::next() {
  if (!scanner_.at_line_end()) {
    scanner_.token();
    fail("more values than there are columns");
  }
  return scanner_.next_line();
}

std::string PublishedTable::word(std::string_view what) {
  const std::string_view found = scanner_.token();
  if (!found.empty()) return std::string(found);
  scanner_.fail(what, found);
  throw Failure(scanner_.error());
}

double PublishedTable::number(std::string_view what, double least) {
  double value = 0.0;
  if (!scanner_.read(value, what)) throw Failure(scanner_.error());
  if (!(value >= least) || !std::isfinite(value))
    fail(fmt::format("{} is {}, not finite and at least {}", what, value, least));
  return value;
}

std::optional<double> PublishedTable::number_or(std::string_view none, std::string_view what) {
  if (scanner_.peek() != none) return number(what);
  scanner_.token();
  return std::nullopt;
}

void PublishedTable::fail(const std::string& problem) const {
  throw Failure(scanner_.problem(problem));
}

}  // namespace tremolo
