#include <vector>

#include "common/text.h"
#include "formats/abaqus/inp_model.h"

namespace tremolo {
namespace {

constexpr TextStyle kInpStyle{.commas = true, .lines = true};
constexpr std::size_t kMostParameters = 100;  // Abaqus knows no keyword with as many

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

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

}  // namespace

std::string InpKeyword::value(const std::string& parameter) const {
  const auto found = parameters.find(parameter);
  return found == parameters.end() ? std::string() : found->second;
}

InpInput::InpInput(std::string_view text, const std::string& path)
    : scanner_(text, path, kInpStyle) {}

std::string_view InpInput::rest() const {
  const std::string_view rest = scanner_.text().substr(scanner_.offset());
  return rest.substr(0, rest.find('\n'));
}

InpInput::Line InpInput::advance() {
  while (started_ ? scanner_.next_line() : !scanner_.at_end()) {
    started_ = true;
    const std::string_view line = trimmed(rest());
    if (line.starts_with("**")) continue;
    return line.starts_with("*") ? Line::kKeyword : Line::kData;
  }
  return Line::kEnd;
}

bool InpInput::next_keyword(InpKeyword& keyword) {
  if (failed_) return false;
  for (Line line = at_keyword_ ? Line::kKeyword : advance(); line != Line::kKeyword;
       line = advance())
    if (line == Line::kEnd) return false;
  at_keyword_ = false;
  std::string text(trimmed(rest()));
  scanner_.peek();
  // Parameters continue on the next line after a comma.
  while (text.ends_with(',')) {
    if (advance() != Line::kData) {
      failed_ = true;
      return scanner_.fail("the parameters that follow the comma", rest());
    }
    text += trimmed(rest());
  }
  const std::vector<std::string_view> parts = split_at_commas(std::string_view(text).substr(1));
  keyword.name = plain_keyword(parts.front());
  keyword.parameters.clear();
  if (parts.size() > kMostParameters) {
    failed_ = true;
    return scanner_.fail("a keyword with fewer parameters", text);
  }
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::size_t equals = parts[n].find('=');
    const std::string name = plain_keyword(trimmed(parts[n].substr(0, equals)));
    keyword.parameters[name] = equals == std::string_view::npos
                                   ? ""
                                   : without_quotes(trimmed(parts[n].substr(equals + 1)));
  }
  return true;
}

bool InpInput::next_data() {
  if (failed_ || at_keyword_) return false;
  const Line line = advance();
  at_keyword_ = line == Line::kKeyword;
  return line == Line::kData;
}

bool InpInput::continues() const {
  return trimmed(rest()).ends_with(',');
}

}  // namespace tremolo
