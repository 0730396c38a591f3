// The collider file: header, table, every section, and distances of what was taken.
#include <cmath>

#include "formats/collider/collider_file.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<ColliderFile> file =
      read_collider(std::as_bytes(std::span(bytes.data(), bytes.size())));
  check_error(file);
  if (!file) return;
  const DistanceGrid& grid = file->grid;
  if (grid.nodes().size() > bytes.size() / sizeof(float)) finding("more nodes than distances");
  const BoundingBox box = grid.box();
  for (const double share : {-1.0, 0.0, 0.3, 0.5, 1.0, 2.0}) {
    const DistanceGrid::Sample sample = grid.at(box.low + share * (box.high - box.low));
    if (!std::isfinite(sample.distance) || !sample.gradient.allFinite())
      finding("a distance that is not finite");
  }
}
