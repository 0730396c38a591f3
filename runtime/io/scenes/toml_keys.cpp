#include "runtime/io/scenes/toml_keys.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "common/damping_ratios.h"
#include "common/text.h"

namespace tremolo {

Error error_at(const std::string& path, const toml::source_region& where, const std::string& what) {
  return content_error(path + ": line " + std::to_string(where.begin.line) + ": " + what);
}

std::string beside(const std::string& path, const std::string& name) {
  const std::filesystem::path file(name);
  if (file.is_absolute()) return name;
  return (std::filesystem::path(path).parent_path() / file).lexically_normal().string();
}

// toml++ converts any float to an integer to check whether it is one, which is undefined for large
// ones.
std::optional<int> whole_number(const toml::node& node) {
  const auto* number = node.as_floating_point();
  // toml++ would convert true to 1.
  if (number == nullptr) return node.is_integer() ? node.value<int>() : std::nullopt;
  const double value = number->get();
  if (!(std::abs(value) <= std::numeric_limits<int>::max()) || value != std::trunc(value))
    return std::nullopt;
  return static_cast<int>(value);
}

std::optional<std::string> text_or_number(const toml::node& node) {
  if (const auto number = whole_number(node)) return std::to_string(*number);
  auto text = node.value_exact<std::string>();
  if (!text || text->find('\0') != std::string::npos) return std::nullopt;
  return text;
}

std::optional<std::vector<std::string>> list_of_texts(const toml::node& node) {
  if (auto single = text_or_number(node)) return std::vector<std::string>{std::move(*single)};
  const toml::array* array = node.as_array();
  if (array == nullptr) return std::nullopt;
  std::vector<std::string> list;
  for (const toml::node& entry : *array) {
    auto text = text_or_number(entry);
    if (!text) return std::nullopt;
    list.push_back(std::move(*text));
  }
  return list;
}

std::optional<std::string> sweep_text(const toml::node& node) {
  if (const auto given = node.value_exact<std::string>(); given && !given->empty()) return given;
  const auto numbers = numbers_of(node);
  if (!numbers || numbers->size() != 2) return std::nullopt;
  return text("%.17g,%.17g", (*numbers)[0], (*numbers)[1]);
}

std::optional<std::string> damping_text(const toml::node& node) {
  if (const auto given = node.value_exact<std::string>(); given && !given->empty()) return given;
  if (const auto number = node.value<double>()) return exact_text(*number);
  const auto numbers = numbers_of(node);
  if (!numbers || numbers->empty()) return std::nullopt;
  std::string text;
  for (const double ratio : *numbers) text += (text.empty() ? "" : ",") + exact_text(ratio);
  return text;
}

std::optional<std::vector<double>> numbers_of(const toml::node& node) {
  const toml::array* array = node.as_array();
  if (array == nullptr) return std::nullopt;
  std::vector<double> numbers;
  for (const toml::node& entry : *array) {
    const auto number = entry.value<double>();
    if (!number || !std::isfinite(*number) || entry.is_boolean()) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

Result<toml::table> parse_toml(std::string_view text, const std::string& path) {
  // A dotted key a.b.c is a table in a table, and these are built and destroyed by recursion. A
  // comma ends a key, so that the dots of numbers do not add up.
  constexpr int kDots = 64, kBraces = 64;
  int line = 1, dots = 0, braces = 0;
  for (const char c : text) {
    dots = c == '\n' || c == ',' ? 0 : dots + (c == '.' ? 1 : 0);
    braces += c == '{' ? 1 : 0;
    if (dots > kDots || braces > kBraces)
      return content_error(path + ": line " + std::to_string(line) +
                           ": tables in tables: a scene has one table a body, with plain keys");
    line += c == '\n' ? 1 : 0;
  }
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    return error_at(path, error.source(), std::string(error.description()));
  }
}

const toml::node* TomlKeys::find(std::string_view key) {
  asked_.emplace(key);
  return table_.get(key);
}

void TomlKeys::fail(std::string_view key, const std::string& problem) {
  const toml::node* node = table_.get(key);
  const toml::source_region& where = node != nullptr ? node->source() : table_.source();
  fail(error_at(path_, where, (what_.empty() ? "" : what_ + ": ") + problem));
}

void TomlKeys::fail(const Error& error) {
  if (!error_) error_ = error;
}

void TomlKeys::wrong(std::string_view key, const char* expected) {
  fail(key, "'" + std::string(key) + "' must be " + expected);
}

void TomlKeys::read(std::string_view key, double& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto value = node->value<double>();
  if (!value || !std::isfinite(*value) || node->is_boolean()) return wrong(key, "a finite number");
  target = *value;
}

void TomlKeys::read(std::string_view key, int& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto value = whole_number(*node);
  if (!value || node->is_boolean()) return wrong(key, "a whole number");
  target = *value;
}

void TomlKeys::read(std::string_view key, bool& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto value = node->value_exact<bool>();
  if (!value) return wrong(key, "true or false");
  target = *value;
}

void TomlKeys::read(std::string_view key, std::string& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto value = node->value_exact<std::string>();
  if (!value || value->find('\0') != std::string::npos) return wrong(key, "a text without a NUL");
  target = *value;
}

void TomlKeys::read(std::string_view key, Eigen::Vector3d& target) {
  const std::vector<double> numbers = read_numbers(key, 3, 3);
  if (numbers.size() == 3) target = {numbers[0], numbers[1], numbers[2]};
}

void TomlKeys::read(std::string_view key, std::vector<std::string>& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  auto value = list_of_texts(*node);
  if (!value) return wrong(key, "a text, a number or a list of these");
  target = std::move(*value);
}

void TomlKeys::read_text_or_number(std::string_view key, std::string& target) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  auto value = text_or_number(*node);
  if (!value) return wrong(key, "a text or a whole number");
  target = std::move(*value);
}

void TomlKeys::read_path(std::string_view key, std::string& target) {
  std::string name;
  read(key, name);
  if (!has(key) || !good()) return;
  if (name.empty()) return wrong(key, "the name of a file");
  target = beside(path_, name);
}

std::vector<double> TomlKeys::read_numbers(std::string_view key, std::size_t least,
                                           std::size_t most) {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  auto numbers = numbers_of(*node);
  if (numbers && numbers->size() >= least && numbers->size() <= most) return std::move(*numbers);
  const std::string expected = "a list of " + std::to_string(least) +
                               (most > least ? " to " + std::to_string(most) : std::string()) +
                               " finite numbers";
  wrong(key, expected.c_str());
  return {};
}

std::vector<const toml::table*> TomlKeys::read_tables(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  if (const toml::table* single = node->as_table()) return {single};
  std::vector<const toml::table*> tables;
  if (const toml::array* array = node->as_array())
    for (const toml::node& entry : *array)
      if (const toml::table* table = entry.as_table()) tables.push_back(table);
  const toml::array* array = node->as_array();
  if (array == nullptr || tables.size() != array->size()) {
    wrong(key, "a table or a list of tables");
    return {};
  }
  return tables;
}

std::size_t TomlKeys::read_word(std::string_view key, const std::vector<std::string_view>& words,
                                std::size_t otherwise) {
  std::string word;
  read(key, word);
  if (!has(key) || !good()) return otherwise;
  const auto at = std::find(words.begin(), words.end(), word);
  if (at != words.end()) return static_cast<std::size_t>(at - words.begin());
  std::string known;
  for (const std::string_view one : words) known += (known.empty() ? "" : ", ") + std::string(one);
  fail(key, "'" + std::string(key) + "' is '" + word + "', must be one of " + known);
  return otherwise;
}

void TomlKeys::need(std::string_view key, const std::string& problem) {
  if (has(key) || missing_) return;
  const std::string where = what_.empty() ? "" : what_ + ": ";
  missing_ = error_at(path_, table_.source(), where + problem);
}

Status TomlKeys::finish() {
  if (!error_)
    for (const auto& [key, node] : table_)
      if (!asked_.contains(key.str()))
        fail(error_at(
            path_, key.source(),
            (what_.empty() ? "" : what_ + ": ") + "unknown key '" + std::string(key.str()) + "'"));
  if (error_) return *error_;
  if (missing_) return *missing_;
  return Success{};
}

}  // namespace tremolo
