// Reads text and bytes of files piece by piece, with errors that say where.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "common/result.h"
#include "common/text.h"

namespace tremolo {

// Rules for splitting a text into tokens. Blanks, tabs, CR and LF always separate.
struct TextStyle {
  char comment = '\0';       // begins a comment up to the end of the line
  bool commas = false;       // commas separate like blanks
  bool lines = false;        // a record is a line: tokens are not taken from the next one
  bool open_end = false;     // a number may end with the text; else it counts as cut off
  bool binary_file = false;  // errors give byte offsets instead of lines
};

// Bytes that some editors and exporters put before the first character of UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// The text after a byte-order mark, or all of it. TextScanner does this itself.
inline std::string_view without_mark(std::string_view text) {
  return text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
}

// Text from a file for an error message: short, in quotes, without control characters.
std::string quoted_text(std::string_view found);

// Reads tokens of a text that must outlive it, after its byte-order mark if there is one. A read
// that fails returns false and leaves an error (kContent) with file, line, the expected and the
// found text.
class TextScanner {
 public:
  TextScanner(std::string_view text, std::string file, TextStyle style = {});

  // True if only blanks and comments are left in the text, or on this line.
  bool at_end();
  bool at_line_end();
  // Goes to the start of the next line that holds something; false at the end of the text.
  bool next_line();

  // The next token, empty if there is none (with style.lines: none on this line).
  std::string_view token();
  std::string_view peek();
  // The rest of this line without its end, comments included; moves to the next line.
  std::string_view rest_of_line();

  // A whole token that is a number in the range of T; what: "a node id".
  template <std::integral T>
  bool read(T& value, std::string_view what) {
    return read_number(value, what);
  }
  bool read(double& value, std::string_view what) { return read_number(value, what); }
  // A word without blanks, a text between double quotes on one line, or just this word.
  bool read_word(std::string& word, std::string_view what);
  bool read_quoted(std::string& text, std::string_view what);
  bool expect(std::string_view word);

  // True if `count` items of at least `bytes` each can follow; call it before memory is allocated.
  bool fits(std::size_t count, std::size_t bytes, std::string_view what);

  // Byte positions in the whole text.
  std::size_t offset() const { return at_; }
  std::size_t remaining() const { return text_.size() - at_; }
  void seek(std::size_t offset);
  std::string_view text() const { return text_; }

  // "FILE, line 12: PROBLEM" at the last token.
  Error problem(const std::string& text) const;
  bool fail(std::string_view expected, std::string_view found);
  const Error& error() const { return error_; }

 private:
  template <class T>
  bool read_number(T& value, std::string_view what);
  bool is_separator(char c) const;
  void skip_separators(bool over_lines);

  std::string_view text_;
  std::string file_;
  TextStyle style_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t token_at_ = 0;  // where the last token began, and on which line
  std::size_t token_line_ = 1;
  Error error_;
};

template <class T>
bool TextScanner::read_number(T& value, std::string_view what) {
  const std::string_view found = token();
  std::string_view digits = found;
  if (digits.size() > 1 && digits.front() == '+' && digits[1] != '-') digits.remove_prefix(1);
  const char* end = digits.data() + digits.size();
  std::from_chars_result read{};
  if constexpr (std::is_same_v<T, double>)
    read = read_decimal(digits.data(), end, value);
  else
    read = std::from_chars(digits.data(), end, value);
  const auto [stop, code] = read;
  if (found.empty() || code != std::errc{} || stop != end) return fail(what, found);
  if (at_ == text_.size() && !style_.open_end)
    return fail("a line end behind " + std::string(what) + " (the file may be cut off)", "");
  return true;
}

// True if a little-endian file's numbers have another byte order than this machine's.
inline constexpr bool kSwapsLittleEndian = std::endian::native != std::endian::little;

// Reads bytes that must outlive it. A read that fails returns false and leaves an error (kContent)
// with file, byte offset, the expected and the found value.
class ByteScanner {
 public:
  // Starts at `offset`; `swap`: the numbers have the other byte order than this machine.
  ByteScanner(std::string_view bytes, std::string file, std::size_t offset, bool swap);

  template <class T>
  bool read(T& value, std::string_view what);

  // True if `count` items of `size` bytes each follow; call it before memory is allocated.
  bool fits(std::size_t count, std::size_t size, std::string_view what);
  bool skip(std::size_t count, std::size_t size, std::string_view what);

  std::size_t offset() const { return at_; }
  std::size_t remaining() const { return bytes_.size() - at_; }
  // "FILE, byte 120: PROBLEM" at the last number read.
  Error problem(const std::string& text) const;
  const Error& error() const { return error_; }

 private:
  std::string_view bytes_;
  std::string file_;
  std::size_t at_;
  std::size_t last_;
  bool swap_;
  Error error_;
};

// The same number in the other byte order.
template <class T>
T swapped_bytes(T value) {
  static_assert(std::is_arithmetic_v<T>);
  // The compiler for pages has no std::bit_cast.
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  std::reverse(bytes.begin(), bytes.end());
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

template <class T>
bool ByteScanner::read(T& value, std::string_view what) {
  if (sizeof(T) > remaining()) return fits(1, sizeof(T), what);
  std::memcpy(&value, bytes_.data() + at_, sizeof(T));
  if (swap_) value = swapped_bytes(value);
  last_ = at_;
  at_ += sizeof(T);
  return true;
}

}  // namespace tremolo
