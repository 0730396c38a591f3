// The sections of a collider file, version 1.0. docs/collider-format.md is the same in prose;
// change both or neither.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "formats/sections/section_layout.h"

namespace tremolo::collider_layout {

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
