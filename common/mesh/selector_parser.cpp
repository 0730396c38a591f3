// The text of a selector -> Selector.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/mesh/selector.h"
#include "common/text.h"

namespace tremolo {
namespace {

constexpr std::pair<std::string_view, Colour> kColours[] = {
    {"black", {0, 0, 0, 255}},      {"white", {255, 255, 255, 255}}, {"red", {255, 0, 0, 255}},
    {"green", {0, 255, 0, 255}},    {"blue", {0, 0, 255, 255}},      {"yellow", {255, 255, 0, 255}},
    {"cyan", {0, 255, 255, 255}},   {"magenta", {255, 0, 255, 255}}, {"orange", {255, 128, 0, 255}},
    {"purple", {128, 0, 128, 255}}, {"brown", {139, 69, 19, 255}},   {"grey", {128, 128, 128, 255}},
    {"gray", {128, 128, 128, 255}},
};

template <class T>
std::optional<T> number(std::string_view text, int base = 10) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const char* end = text.data() + text.size();
  std::from_chars_result result{};
  if constexpr (std::is_floating_point_v<T>)
    result = read_decimal(text.data(), end, value);
  else
    result = std::from_chars(text.data(), end, value, base);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<SelectorLength> length(std::string_view text) {
  text = trimmed(text);
  const bool percent = text.ends_with('%');
  if (percent) text.remove_suffix(1);
  const std::optional<double> value = number<double>(text);
  if (!value) return std::nullopt;
  return SelectorLength{*value, percent};
}

// `read` of each part between commas.
template <class T, class Read>
std::optional<std::vector<T>> list(std::string_view text, const Read& read) {
  std::vector<T> values;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::optional<T> value = read(text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    text.remove_prefix(comma + 1);
  }
}

std::optional<std::vector<SelectorLength>> lengths(std::string_view text, std::size_t count) {
  auto values = list<SelectorLength>(text, length);
  if (!values || values->size() != count) return std::nullopt;
  return values;
}

SelectorPoint point_of(const std::vector<SelectorLength>& values, std::size_t first) {
  return {values[first], values[first + 1], values[first + 2]};
}

Error malformed(const std::string& text, const std::string& what) {
  return {ErrorKind::kUsage,
          "selector `" + text + "`: expected " + what + "; a selector is " + kSelectorGrammar};
}

// An axis and a comparison sign make a half space; nullopt: the text is something else.
std::optional<Result<Selector>> parse_half_space(const std::string& text, std::string_view body) {
  if (body.empty() || body[0] < 'x' || body[0] > 'z') return std::nullopt;
  const std::string_view rest = trimmed(body.substr(1));
  if (rest.empty() || (rest[0] != '<' && rest[0] != '>' && rest[0] != '=')) return std::nullopt;
  using Comparison = SelectHalfSpace::Comparison;
  const bool or_equal = rest.size() > 1 && rest[1] == '=';
  const std::optional<SelectorLength> bound = length(rest.substr(or_equal ? 2 : 1));
  if (rest[0] == '=' || !bound) return malformed(text, "<, <=, > or >= and a finite number");
  SelectHalfSpace half{body[0] - 'x', Comparison::kLess, *bound};
  if (rest[0] == '<')
    half.comparison = or_equal ? Comparison::kLessEqual : Comparison::kLess;
  else
    half.comparison = or_equal ? Comparison::kGreaterEqual : Comparison::kGreater;
  return Selector{text, half, {}};
}

Result<Selector> parse_box(const std::string& text, std::string_view body) {
  const auto values = lengths(body, 6);
  if (!values) return malformed(text, "six finite numbers behind `box:`");
  const SelectBox box{point_of(*values, 0), point_of(*values, 3)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (box.low[axis].percent == box.high[axis].percent &&
        box.low[axis].value > box.high[axis].value)
      return malformed(text, "a box whose first corner is not above its second");
  return Selector{text, box, {}};
}

Result<Selector> parse_sphere(const std::string& text, std::string_view body) {
  const auto values = lengths(body, 4);
  if (!values || (*values)[3].value < 0)
    return malformed(text, "a point and a radius, X,Y,Z,R, behind `sphere:`");
  return Selector{text, SelectSphere{point_of(*values, 0), (*values)[3]}, {}};
}

Result<Selector> parse_plane(const std::string& text, std::string_view body) {
  std::string commas(body);
  std::replace(commas.begin(), commas.end(), ';', ',');
  const auto values = lengths(commas, 6);
  const char* expected = "a point and a normal, X,Y,Z,NX,NY,NZ, behind `plane:`";
  if (!values) return malformed(text, expected);
  Eigen::Vector3d normal;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((*values)[3 + axis].percent) return malformed(text, expected);
    normal[axis] = (*values)[3 + axis].value;
  }
  const double size = normal.cwiseAbs().maxCoeff();
  if (size == 0.0) return malformed(text, "a normal other than zero");
  return Selector{text, SelectPlane{point_of(*values, 0), (normal / size).normalized()}, {}};
}

Result<Selector> parse_near(const std::string& text, std::string_view body) {
  const auto count_commas = std::count(body.begin(), body.end(), ',');
  std::size_t wanted = 1;
  if (count_commas == 3) {
    const std::size_t last = body.rfind(',');
    const std::optional<VertexId> count = number<VertexId>(body.substr(last + 1));
    if (!count || *count < 1)
      return malformed(text, "a count of at least 1 behind the point of `near:`");
    wanted = *count;
    body = body.substr(0, last);
  }
  const auto values = lengths(body, 3);
  if (!values) return malformed(text, "a point X,Y,Z, and perhaps a count, behind `near:`");
  return Selector{text, SelectNear{point_of(*values, 0), wanted}, {}};
}

std::optional<Colour> colour_of(std::string_view name) {
  name = trimmed(name);
  if (name.starts_with('#')) {
    const std::optional<std::uint32_t> value = number<std::uint32_t>(name.substr(1), 16);
    if (!value || name.size() != 7 || name[1] == '+') return std::nullopt;
    return Colour{static_cast<std::uint8_t>(*value >> 16), static_cast<std::uint8_t>(*value >> 8),
                  static_cast<std::uint8_t>(*value), 255};
  }
  const std::string plain = lower_case(name);
  for (const auto& [known, colour] : kColours)
    if (known == plain) return colour;
  return std::nullopt;
}

Result<Selector> parse_colour(const std::string& text, std::string_view body) {
  const std::size_t comma = body.find(',');
  SelectColour select;
  const std::optional<Colour> colour = colour_of(body.substr(0, comma));
  if (!colour) {
    std::string names;
    for (const auto& [name, value] : kColours) names.append(" ").append(name);
    return malformed(text, "#RRGGBB or one of" + names + " behind `colour:`");
  }
  select.colour = *colour;
  if (comma != std::string_view::npos) {
    const std::optional<int> tolerance = number<int>(body.substr(comma + 1));
    if (!tolerance || *tolerance < 0 || *tolerance > 255)
      return malformed(text, "a tolerance from 0 to 255 behind the colour");
    select.tolerance = *tolerance;
  }
  return Selector{text, select, {}};
}

Result<Selector> parse_vertices(const std::string& text, std::string_view body) {
  auto ids = list<VertexId>(body, [](std::string_view part) { return number<VertexId>(part); });
  if (!ids || *std::min_element(ids->begin(), ids->end()) < 0)
    return malformed(text, "vertex ids from 0, separated by commas, behind `vertex:`");
  return Selector{text, SelectVertices{std::move(*ids)}, {}};
}

Result<Selector> parse_file(const std::string& text, std::string_view body) {
  const std::string_view path = trimmed(body);
  if (path.empty()) return malformed(text, "a path behind `file:`");
  return Selector{text, SelectFile{std::string(path), {}}, {}};
}

Result<Selector> parse_set(const std::string& text, std::string_view body) {
  const std::string_view name = trimmed(body);
  if (name.empty()) return malformed(text, "a name behind `set:`");
  return Selector{text, SelectSet{std::string(name)}, {}};
}

using Parse = Result<Selector> (*)(const std::string& text, std::string_view body);
constexpr std::pair<std::string_view, Parse> kPrefixes[] = {
    {"box:", parse_box},         {"sphere:", parse_sphere}, {"plane:", parse_plane},
    {"near:", parse_near},       {"colour:", parse_colour}, {"color:", parse_colour},
    {"vertex:", parse_vertices}, {"file:", parse_file},     {"set:", parse_set},
};

Result<Selector> parse_one(const std::string& text, std::string_view body) {
  if (body.empty()) return malformed(text, "a text that is not empty");
  if (body == "none") return Selector{text, SelectNone{}, {}};
  for (const auto& [prefix, parse] : kPrefixes)
    if (body.starts_with(prefix)) return parse(text, body.substr(prefix.size()));
  if (auto half_space = parse_half_space(text, body)) return *half_space;
  return Selector{text, SelectSet{std::string(body)}, {}};
}

}  // namespace

Result<Selector> parse_selector(const std::string& text) {
  constexpr std::string_view kAnd = " and ";
  std::optional<Selector> first;
  std::string_view rest = trimmed(text);
  for (bool last = false; !last;) {
    // A path may have blanks in it.
    const std::size_t end = rest.starts_with("file:") ? std::string_view::npos : rest.find(kAnd);
    last = end == std::string_view::npos;
    const std::string_view part = trimmed(rest.substr(0, end));
    // The messages of the parts are short, because a long text has many parts.
    Result<Selector> parsed = parse_one(first ? std::string(part) : text, part);
    if (!parsed) return parsed;
    const bool alone = last && !first;
    if (!alone && std::holds_alternative<SelectNone>(parsed->choice))
      return malformed(text, "`none` to stand alone");
    if (first)
      first->further.push_back(std::move(*parsed));
    else
      first = std::move(*parsed);
    if (!last) rest = trimmed(rest.substr(end + kAnd.size()));
  }
  return std::move(*first);
}

std::vector<std::string> files_of_selector(const Selector& selector) {
  std::vector<std::string> files;
  const auto add = [&files](const Selector& part) {
    if (const auto* file = std::get_if<SelectFile>(&part.choice)) files.push_back(file->path);
  };
  add(selector);
  for (const Selector& part : selector.further) add(part);
  return files;
}

std::vector<std::string> files_of_selector(const std::string& text) {
  const Result<Selector> selector = parse_selector(text);
  return selector ? files_of_selector(*selector) : std::vector<std::string>();
}

}  // namespace tremolo
