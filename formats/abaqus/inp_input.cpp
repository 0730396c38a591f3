#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "common/text.h"
#include "formats/abaqus/inp_model.h"
#include "formats/file/input_file.h"
#include "formats/file/named_below.h"

namespace tremolo {
namespace {

constexpr TextStyle kInpStyle{.commas = true, .lines = true};
constexpr std::size_t kMostParameters = 100;  // Abaqus knows no keyword with as many
constexpr std::size_t kDeepest = 5;           // files in files, as Abaqus takes them
constexpr std::size_t kMostRepeats = 16;      // bytes that are read for one on disk

// Commas between double quotes do not separate.
std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  std::size_t start = 0;
  bool quoted = false;
  for (std::size_t at = 0; at <= text.size(); ++at) {
    if (at < text.size() && text[at] == '"') quoted = !quoted;
    if (at < text.size() && (text[at] != ',' || quoted)) continue;
    parts.push_back(trimmed(text.substr(start, at - start)));
    start = at + 1;
  }
  return parts;
}

std::string without_quotes(std::string_view value) {
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"')
    value = value.substr(1, value.size() - 2);
  return std::string(value);
}

// "Solid  Section" -> "SOLID SECTION".
std::string plain_keyword(std::string_view text) {
  std::string name;
  for (const char c : upper_case(text)) {
    const bool blank = c == ' ' || c == '\t';
    if (!blank || (!name.empty() && name.back() != ' ')) name += blank ? ' ' : c;
  }
  return name;
}

// "*Solid Section, elset=a" -> "SOLID SECTION".
std::string keyword_of(std::string_view line) {
  return plain_keyword(trimmed(line.substr(1, line.find(',') - 1)));
}

InpKeyword parse_keyword(const std::vector<std::string_view>& parts) {
  InpKeyword keyword{plain_keyword(parts.front()), {}};
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::size_t equals = parts[n].find('=');
    const std::string name = plain_keyword(trimmed(parts[n].substr(0, equals)));
    keyword.parameters[name] = equals == std::string_view::npos
                                   ? ""
                                   : without_quotes(trimmed(parts[n].substr(equals + 1)));
  }
  return keyword;
}

std::string place_of(const std::string& path) {
  std::error_code code;
  const std::filesystem::path place = std::filesystem::canonical(path, code);
  return code ? std::string() : place.string();
}

}  // namespace

std::string InpKeyword::value(const std::string& parameter) const {
  const auto found = parameters.find(parameter);
  return found == parameters.end() ? std::string() : found->second;
}

InpInput::InpInput(std::string_view text, const std::string& path)
    : bytes_(text.size()), distinct_bytes_(text.size()) {
  sources_.push_back({TextScanner(text, path, kInpStyle), path, place_of(path)});
}

std::string_view InpInput::rest() const {
  const TextScanner& scanner = sources_.back().scanner;
  const std::string_view rest = scanner.text().substr(scanner.offset());
  return rest.substr(0, rest.find('\n'));
}

bool InpInput::fail(const std::string& text) {
  error_ = problem(text);
  return false;
}

InpInput::Line InpInput::advance() {
  while (!failed()) {
    Source& source = sources_.back();
    if (!(source.started ? source.scanner.next_line() : !source.scanner.at_end())) {
      if (sources_.size() == 1) return Line::kEnd;
      sources_.pop_back();
      continue;
    }
    source.started = true;
    const std::string_view line = trimmed(rest());
    if (line.starts_with("**")) continue;
    if (!line.starts_with("*")) return Line::kData;
    if (keyword_of(line) != "INCLUDE") return Line::kKeyword;
    source.scanner.peek();
    include(parse_keyword(split_at_commas(line.substr(1))).value("INPUT"));
  }
  return Line::kEnd;
}

bool InpInput::include(const std::string& written) {
  const std::optional<std::string> below = named_below(sources_.back().path, written);
  if (!below)
    return fail("expected INPUT=FILE of a file in the same folder or below, found " +
                quoted_text(written));
  const std::string& path = *below;
  const std::string place = place_of(path);
  for (const Source& source : sources_)
    if (!place.empty() && source.place == place)
      return fail(quoted_text(written) + " includes itself: " + source.path +
                  " is being read already");
  if (sources_.size() > kDeepest)
    return fail("expected files in files of at most " + std::to_string(kDeepest) +
                " levels, found one more in " + quoted_text(written));
  auto known = texts_.find(place);
  if (known == texts_.end()) {
    Result<std::string> text = read_whole_file(path);
    if (!text) {
      error_ = text.error();
      error_.message += " (" + problem("it is included here").message + ")";
      return false;
    }
    distinct_bytes_ += text->size();
    known = texts_.emplace(place, std::move(*text)).first;
  }
  bytes_ += known->second.size();
  if (bytes_ > kMostRepeats * distinct_bytes_)
    return fail("expected files that are included " + std::to_string(kMostRepeats) +
                " times at most, found more of " + quoted_text(written));
  sources_.push_back({TextScanner(known->second, path, kInpStyle), path, place});
  return true;
}

bool InpInput::next_keyword(InpKeyword& keyword) {
  if (failed()) return false;
  for (Line line = at_keyword_ ? Line::kKeyword : advance(); line != Line::kKeyword;
       line = advance())
    if (line == Line::kEnd) return false;
  at_keyword_ = false;
  std::string text(trimmed(rest()));
  line().peek();
  // Parameters continue on the next line after a comma.
  while (text.ends_with(',')) {
    if (advance() != Line::kData)
      return !failed() &&
             fail("expected the parameters that follow the comma, found " + quoted_text(rest()));
    text += trimmed(rest());
  }
  const std::vector<std::string_view> parts = split_at_commas(std::string_view(text).substr(1));
  if (parts.size() > kMostParameters)
    return fail("expected a keyword with fewer parameters, found " + quoted_text(text));
  keyword = parse_keyword(parts);
  return true;
}

bool InpInput::next_data() {
  if (failed() || at_keyword_) return false;
  const Line line = advance();
  at_keyword_ = line == Line::kKeyword;
  return line == Line::kData;
}

bool InpInput::continues() const {
  return trimmed(rest()).ends_with(',');
}

}  // namespace tremolo
