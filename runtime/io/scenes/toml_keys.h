// Values of a TOML table, key by key, with errors that name file, line and key.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <toml++/toml.h>

#include "common/result.h"

namespace tremolo {

// "FILE: line 12: WHAT", kContent.
Error error_at(const std::string& path, const toml::source_region& where, const std::string& what);

// The path of `name`, a name relative to the file `path`.
std::string beside(const std::string& path, const std::string& name);

// An integer, or a float with an integral value. Nothing for another node or a value out of range.
std::optional<int> whole_number(const toml::node& node);

// A text without a NUL, before which the system would end a path; or a whole number as text.
std::optional<std::string> text_or_number(const toml::node& node);

// One of these or a list of them.
std::optional<std::vector<std::string>> list_of_texts(const toml::node& node);

// "F1,F2" of a text or of two numbers; nothing for another node.
std::optional<std::string> sweep_text(const toml::node& node);

// Damping ratios as a text, "2%", or as one number or several, 0.02 or [0.02, 0.01]; nothing for
// another node.
std::optional<std::string> damping_text(const toml::node& node);

// A list of finite numbers; nothing for another node.
std::optional<std::vector<double>> numbers_of(const toml::node& node);

// Parses the text. Errors: kContent with the line; also for tables nested so deeply that building
// them, which is done by recursion, could exhaust the stack.
Result<toml::table> parse_toml(std::string_view text, const std::string& path);

// Reads known keys of a table. finish() returns the first error, or else an error for the first key
// that was never read. A missing key leaves its target unchanged.
class TomlKeys {
 public:
  // what: the table's name in errors, as "body 'horse'"; may be empty. The table must outlive this.
  TomlKeys(const toml::table& table, std::string path, std::string what)
      : table_(table), path_(std::move(path)), what_(std::move(what)) {}

  bool has(std::string_view key) const { return table_.contains(key); }
  void read(std::string_view key, double& target);
  void read(std::string_view key, int& target);
  void read(std::string_view key, bool& target);
  void read(std::string_view key, std::string& target);
  void read(std::string_view key, Eigen::Vector3d& target);
  void read(std::string_view key, std::vector<std::string>& target);
  void read_text_or_number(std::string_view key, std::string& target);
  // A file's name, made relative to the file that names it.
  void read_path(std::string_view key, std::string& target);
  // So many numbers. least and most: how many there may be.
  std::vector<double> read_numbers(std::string_view key, std::size_t least, std::size_t most);
  // A table, or a list of tables.
  std::vector<const toml::table*> read_tables(std::string_view key);
  // One of the words: its index, or `otherwise` if the key is missing.
  std::size_t read_word(std::string_view key, const std::vector<std::string_view>& words,
                        std::size_t otherwise);
  // The key's value; null if there is none.
  const toml::node* find(std::string_view key);

  // At the key, or at the table if it has no such key. Keeps the first error only.
  void fail(std::string_view key, const std::string& problem);
  void fail(const Error& error);
  // The table says nothing without this key: an error of finish(), after all others.
  void need(std::string_view key, const std::string& problem);
  bool good() const { return !error_; }
  Status finish();

 private:
  void wrong(std::string_view key, const char* expected);

  const toml::table& table_;
  std::string path_, what_;
  std::set<std::string, std::less<>> asked_;
  std::optional<Error> error_, missing_;
};

}  // namespace tremolo
