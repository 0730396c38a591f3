// Geomview's OFF as text.
#include <charconv>

#include "formats/polygons/off_text.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<OffMesh> off = parse_off(bytes);
  check_error(off);
  if (!off) return;
  const std::size_t vertices = off->coordinates.size();
  const auto none_or = [](std::size_t size, std::size_t count) {
    return size == 0 || size == count;
  };
  if (off->first.empty() || off->first.front() != 0 || off->first.back() != off->corners.size() ||
      !none_or(off->normals.size(), vertices) || !none_or(off->uvs.size(), vertices) ||
      !none_or(off->colours.size(), vertices) ||
      !none_or(off->face_colours.size(), off->first.size() - 1))
    finding("an OFF whose parts do not fit");
  for (std::size_t f = 0; f + 1 < off->first.size(); ++f)
    if (off->first[f] > off->first[f + 1]) finding("a face that ends before it begins");
  for (const VertexId v : off->corners)
    if (v < 0 || static_cast<std::size_t>(v) >= vertices) finding("a corner that is not there");
  for (const auto& written : off->coordinates)
    for (std::string_view each : written) {
      if (each.starts_with('+')) each.remove_prefix(1);
      double value = 0;
      const auto [end, code] = std::from_chars(each.data(), each.data() + each.size(), value);
      if (code != std::errc{} || end != each.data() + each.size())
        finding("a coordinate that is no number");
    }
}
