// Collider files: the signed distances of a surface on a grid (docs/collider-format.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/distance/distance_grid.h"
#include "common/result.h"
#include "formats/sections/section_layout.h"

namespace tremolo::collider_layout {

// The sections of a collider file, version 1.0. docs/collider-format.md is the same in prose;
// change both or neither.

using namespace section_layout;

inline constexpr std::uint16_t kMajor = 1;
inline constexpr std::uint16_t kMinor = 0;
inline constexpr FileKind kKind = {
    {'T', 'R', 'E', 'M', 'C', 'O', 'L', 'L'}, kMajor, "a collider file"};

inline constexpr std::string_view kCounts = "grid_counts";     // u64, 3 x 1: nodes along x, y, z
inline constexpr std::string_view kFrame = "grid_frame";       // f64, 4 x 1: origin, spacing, m
inline constexpr std::string_view kDistances = "distances";    // f32, one a node, m
inline constexpr std::string_view kProvenance = "provenance";  // u8, JSON

inline constexpr std::size_t kFrameSize = 4;

}  // namespace tremolo::collider_layout

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
