// Collider files: the signed distances of a surface on a grid (docs/collider-format.md).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/distance/distance_grid.h"
#include "common/result.h"

namespace tremolo {

// A grid of distances.
struct ColliderData {
  GridNodes nodes;
  std::vector<float> distances;  // one per node, m, negative inside (distance_grid.h)
  std::string provenance;        // a JSON object, UTF-8; empty: none
};

// The bytes of the file; the same data give the same bytes. Errors (kContent): those of
// DistanceGrid::create().
Result<std::vector<std::byte>> encode_collider(const ColliderData& data);

// The same, written under a temporary name and renamed to `path`. Errors: also kSystem.
Status write_collider(const std::string& path, const ColliderData& data);

struct ColliderFile {
  DistanceGrid grid;
  std::string provenance;
};

// Reads with distrust: header, table, shapes, checksums, and that the numbers may be distances.
// Memory: four bytes a node. Errors name the file and the section or node: kContent, and kSystem
// for a file that cannot be read.
Result<ColliderFile> read_collider(const std::string& path);
// `name` is for errors.
Result<ColliderFile> read_collider(std::span<const std::byte> bytes,
                                   const std::string& name = "memory");

}  // namespace tremolo
