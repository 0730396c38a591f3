#include "formats/file/scanner.h"

#include <utility>

namespace tremolo {
namespace {

constexpr std::size_t kShown = 40;  // characters of a found text in an error message

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace

std::string quoted_text(std::string_view found) {
  std::string shown = "`";
  for (char c : found.substr(0, kShown)) shown += c < ' ' || c > '~' ? '?' : c;
  return shown + (found.size() > kShown ? "...`" : "`");
}

TextScanner::TextScanner(std::string_view text, std::string file, TextStyle style)
    : text_(text),
      file_(std::move(file)),
      style_(style),
      at_(text.size() - without_mark(text).size()) {}

bool TextScanner::is_separator(char c) const {
  return is_blank(c) || c == '\n' || (c == ',' && style_.commas);
}

void TextScanner::skip_separators(bool over_lines) {
  for (; at_ < text_.size(); ++at_) {
    const char c = text_[at_];
    if (c == '\n') {
      if (!over_lines) return;
      ++line_;
    } else if (c == style_.comment && c != '\0') {
      at_ = std::min(text_.find('\n', at_), text_.size());
      if (at_ == text_.size() || !over_lines) return;
      ++line_;
    } else if (!is_separator(c)) {
      return;
    }
  }
}

bool TextScanner::at_end() {
  skip_separators(true);
  return at_ == text_.size();
}

bool TextScanner::at_line_end() {
  skip_separators(false);
  return at_ == text_.size() || text_[at_] == '\n';
}

bool TextScanner::next_line() {
  rest_of_line();
  return !at_end();
}

std::string_view TextScanner::token() {
  skip_separators(!style_.lines);
  token_at_ = at_;
  token_line_ = line_;
  while (at_ < text_.size() && !is_separator(text_[at_]) &&
         (text_[at_] != style_.comment || style_.comment == '\0'))
    ++at_;
  return text_.substr(token_at_, at_ - token_at_);
}

std::string_view TextScanner::peek() {
  skip_separators(!style_.lines);
  const std::size_t here = at_;
  const std::string_view next = token();
  at_ = here;
  return next;
}

std::string_view TextScanner::rest_of_line() {
  const std::size_t start = at_;
  token_at_ = at_;
  token_line_ = line_;
  at_ = std::min(text_.find('\n', at_), text_.size());
  std::string_view rest = text_.substr(start, at_ - start);
  if (!rest.empty() && rest.back() == '\r') rest.remove_suffix(1);
  if (at_ < text_.size()) {
    ++at_;
    ++line_;
  }
  return rest;
}

bool TextScanner::read_word(std::string& word, std::string_view what) {
  const std::string_view found = token();
  if (found.empty()) return fail(what, found);
  word = found;
  return true;
}

bool TextScanner::read_quoted(std::string& text, std::string_view what) {
  skip_separators(!style_.lines);
  token_at_ = at_;
  token_line_ = line_;
  const std::string_view line = text_.substr(at_, text_.find('\n', at_) - at_);
  const std::size_t end = line.find('"', 1);
  if (line.empty() || line.front() != '"' || end == std::string_view::npos)
    return fail(std::string(what) + " in double quotes", line);
  text = line.substr(1, end - 1);
  at_ += end + 1;
  return true;
}

bool TextScanner::expect(std::string_view word) {
  const std::string_view found = token();
  return found == word || fail(quoted_text(word), found);
}

bool TextScanner::fits(std::size_t count, std::size_t bytes, std::string_view what) {
  // The last item needs no separator after it.
  if (bytes == 0 || count <= (remaining() + 1) / bytes) return true;
  error_ = problem("expected " + std::to_string(count) + " " + std::string(what) + ", found only " +
                   std::to_string(remaining()) + " bytes behind this count");
  return false;
}

void TextScanner::seek(std::size_t offset) {
  offset = std::min(offset, text_.size());
  if (offset > at_)
    line_ += std::count(text_.begin() + at_, text_.begin() + offset, '\n');
  else
    line_ -= std::count(text_.begin() + offset, text_.begin() + at_, '\n');
  at_ = offset;
  token_at_ = offset;
  token_line_ = line_;
}

Error TextScanner::problem(const std::string& text) const {
  const std::string place = style_.binary_file ? ", byte " + std::to_string(token_at_)
                                               : ", line " + std::to_string(token_line_);
  return content_error(file_ + place + ": " + text);
}

bool TextScanner::fail(std::string_view expected, std::string_view found) {
  const char* nothing = at_ == text_.size() ? "the end of the file" : "the end of the line";
  error_ = problem("expected " + std::string(expected) + ", found " +
                   (found.empty() ? nothing : quoted_text(found)));
  return false;
}

ByteScanner::ByteScanner(std::string_view bytes, std::string file, std::size_t offset, bool swap)
    : bytes_(bytes),
      file_(std::move(file)),
      at_(std::min(offset, bytes.size())),
      last_(at_),
      swap_(swap) {}

bool ByteScanner::fits(std::size_t count, std::size_t size, std::string_view what) {
  if (size == 0 || count <= remaining() / size) return true;
  last_ = at_;
  error_ =
      problem("expected " + (count == 1 ? "" : std::to_string(count) + " ") + std::string(what) +
              " (" + std::to_string(size) + (count == 1 ? " bytes)" : " bytes each)") +
              ", found only " + std::to_string(remaining()) + " bytes before the end of the file");
  return false;
}

bool ByteScanner::skip(std::size_t count, std::size_t size, std::string_view what) {
  if (!fits(count, size, what)) return false;
  at_ += count * size;
  return true;
}

Error ByteScanner::problem(const std::string& text) const {
  return content_error(file_ + ", byte " + std::to_string(last_) + ": " + text);
}

}  // namespace tremolo
