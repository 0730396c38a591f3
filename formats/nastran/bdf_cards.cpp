#include "formats/nastran/bdf_cards.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "common/text.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

constexpr std::size_t kNarrow = 8;         // columns of a small field, and of every first field
constexpr std::size_t kWide = 16;          // of a large field
constexpr std::size_t kMostFields = 1000;  // far above what a card of the mesh has

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.push_back(trimmed(text.substr(start, end - start)));
    start = end + 1;
  }
  return parts;
}

bool is_free(std::string_view line) {
  return line.find(',') != std::string_view::npos;
}

// The first field: of a free line up to the comma, else eight columns.
std::string_view first_field(std::string_view line) {
  return trimmed(is_free(line) ? line.substr(0, line.find(',')) : line.substr(0, kNarrow));
}

}  // namespace

std::optional<double> bdf_real(std::string_view field) {
  std::string text;
  for (std::size_t n = 0; n < field.size(); ++n) {
    const char c = field[n] == 'd' || field[n] == 'D' || field[n] == 'e' ? 'E' : field[n];
    const bool sign = c == '+' || c == '-';
    if (sign && !text.empty() && text.back() != 'E') text += 'E';
    if (c == '+' && (text.empty() || text.back() == 'E')) continue;
    text += c;
  }
  double value = 0;
  const auto [end, code] = read_decimal(text.data(), text.data() + text.size(), value);
  if (text.empty() || code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> bdf_integer(std::string_view field) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (field.empty() || code != std::errc{} || end != field.data() + field.size())
    return std::nullopt;
  return value;
}

BdfCards::BdfCards(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {}

Error BdfCards::problem(std::size_t line, const std::string& text) const {
  return content_error(path_ + ", line " + std::to_string(line) + ": " + text);
}

// The next line that is neither empty nor a comment, without its end and any text after a dollar.
bool BdfCards::next_line(std::string_view& line) {
  while (at_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++line_;
    line = line.substr(0, line.find('$'));
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    if (!trimmed(line).empty()) return true;
  }
  return false;
}

Status BdfCards::read_case_control(std::vector<BdfSet>& sets) {
  const std::size_t start_at = at_;
  const std::size_t start_line = line_;
  std::string_view line;
  while (next_line(line)) {
    std::string words = upper_case(trimmed(line));
    if (words.starts_with("BEGIN")) return Success{};
    if (!words.starts_with("SET ") && !words.starts_with("SET\t")) continue;
    const std::size_t begins = line_;
    while (words.ends_with(',') && next_line(line)) words += upper_case(trimmed(line));
    const std::size_t equals = words.find('=');
    const auto id = bdf_integer(trimmed(std::string_view(words).substr(4, equals - 4)));
    // A set of all, or of names: selectors do not need it.
    if (equals == std::string::npos || !id) continue;
    BdfSet set{*id, {}};
    for (const std::string_view part : split(std::string_view(words).substr(equals + 1), ',')) {
      const std::size_t thru = part.find("THRU");
      const auto first = bdf_integer(trimmed(part.substr(0, thru)));
      const auto last =
          thru == std::string_view::npos ? first : bdf_integer(trimmed(part.substr(thru + 4)));
      if (!first || !last)
        return problem(begins, "expected ids such as 3 or 1 THRU 10 in SET " + std::to_string(*id) +
                                   ", found " + quoted_text(part));
      set.ranges.emplace_back(*first, *last);
    }
    sets.push_back(std::move(set));
  }
  at_ = start_at;
  line_ = start_line;
  sets.clear();
  return Success{};
}

bool BdfCards::is_continuation(std::string_view line) const {
  const std::string_view first = first_field(line);
  return first.empty() || first.front() == '+' || first.front() == '*';
}

void BdfCards::append_fields(std::string_view line, bool large, BdfCard& card) const {
  const std::size_t on_line = large ? 4 : 8;
  const std::size_t before = card.fields.size();
  if (is_free(line)) {
    const std::vector<std::string_view> parts = split(line, ',');
    // The last field is followed by the name of the continuation, which the next line repeats. Some
    // writers put all fields on one line instead.
    const bool named = parts.size() > on_line + 1 &&
                       (parts[on_line + 1].empty() || parts[on_line + 1].front() == '+' ||
                        parts[on_line + 1].front() == '*');
    const std::size_t end = named ? on_line + 1 : parts.size();
    card.fields.insert(card.fields.end(), parts.begin() + 1, parts.begin() + end);
  } else {
    const std::size_t width = large ? kWide : kNarrow;
    for (std::size_t n = 0; n < on_line; ++n) {
      const std::size_t column = kNarrow + n * width;
      card.fields.push_back(column < line.size() ? trimmed(line.substr(column, width))
                                                 : std::string_view());
    }
  }
  if (card.fields.size() < before + on_line) card.fields.resize(before + on_line);
}

bool BdfCards::next(BdfCard& card) {
  std::string_view line;
  if (failed() || ended_ || !next_line(line)) return false;
  card.line = line_;
  card.fields.clear();
  std::string name = upper_case(first_field(line));
  if (name == "ENDDATA") {
    ended_ = true;
    return false;
  }
  if (name.starts_with("INCLUDE") || is_continuation(line)) {
    error_ = problem(line_, name.starts_with("INCLUDE")
                                ? "INCLUDE is not read: put what it includes into the file itself"
                                : "expected a card, found the continuation of one: " +
                                      quoted_text(trimmed(line)));
    return false;
  }
  const bool large = name.ends_with('*');
  if (large) name.pop_back();
  card.name = std::string(trimmed(name));
  append_fields(line, large, card);
  for (;;) {
    const std::size_t here = at_;
    const std::size_t here_line = line_;
    if (!next_line(line) || !is_continuation(line)) {
      at_ = here;
      line_ = here_line;
      break;
    }
    if (card.fields.size() > kMostFields) continue;
    append_fields(line, first_field(line).starts_with('*'), card);
  }
  return true;
}

}  // namespace tremolo
