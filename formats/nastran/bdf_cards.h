// The cards of a Nastran bulk data file, in small, large and free field.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// fields: those after the name, trimmed, with those of continuation lines; an omitted field is
// empty. Small and free field have eight on a line, large field four.
struct BdfCard {
  std::string name;  // upper case, without the star of the large field
  std::vector<std::string_view> fields;
  std::size_t line = 0;  // on which the card begins

  // Empty after the last field.
  std::string_view field(std::size_t n) const {
    return n < fields.size() ? fields[n] : std::string_view();
  }
};

// A set of the case control section: `SET 5 = 1 THRU 10, 12`.
struct BdfSet {
  std::int64_t id = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> ranges;  // first and last
};

// Walks over the cards of a text that must outlive it.
class BdfCards {
 public:
  BdfCards(std::string_view text, std::string path);

  // Reads the part before BEGIN BULK: the sets. A file without that line has only cards.
  Status read_case_control(std::vector<BdfSet>& sets);
  // False at ENDDATA, at the end of the file, and after a line that is no card (error()).
  bool next(BdfCard& card);
  // Whether ENDDATA was met.
  bool ended() const { return ended_; }
  const Error& error() const { return error_; }
  bool failed() const { return !error_.message.empty(); }
  Error problem(std::size_t line, const std::string& text) const;

 private:
  bool next_line(std::string_view& line);
  bool is_continuation(std::string_view line) const;
  void append_fields(std::string_view line, bool large, BdfCard& card) const;

  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  bool ended_ = false;
  Error error_;
};

// Numbers in Nastran's form: an exponent may have no letter ("1.5-3"), or D. Nothing if the field
// is not a number.
std::optional<double> bdf_real(std::string_view field);
std::optional<std::int64_t> bdf_integer(std::string_view field);

}  // namespace tremolo
