// A report as a page: one file that needs no other and no network, with the scripts that draw it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/io/exchange/animation_writer.h"

namespace tremolo {

// report: an object as JSON, which page.html's scripts show:
//
//     {"title": text, "subtitle": text, "sections": [{"title": text, "parts": [part, ...]}, ...]}
//     part: {"kind": kind, kind: value}
//
// kind is `heading` or `paragraph` (a text), `table` ({columns, rows, caption}), `criteria`,
// `charts` ({charts, columns, height, caption, linked}), `cells`, or `film` (page_motion). In texts
// `code` stands between backticks; nothing is read as HTML, whatever it says.
std::string page_document(std::string_view report);

// An animation as the `film` of a page: shapes once, coordinates and poses frame by frame.
//
//     x = T (X + sum_i q_i U_i),      U_i in float, or as s_i n_i with whole numbers |n_i| <= 32767
//
// Whole numbers halve the page. A component of U_i q_i errs by at most |q_i| s_i / 2 then; they are
// taken where these errors sum to less than 5e-6 of the shape's size at every frame, so that no
// vertex is farther off than 1e-5 of it.

// Limits for a body that WebGL 2 guarantees.
inline constexpr std::size_t kPageCoordinates = 192;
inline constexpr std::size_t kPageBones = 24;

// json: an object with
//   up      "z" or "y", of the world
//   times   s, array of f frames
//   shapes  of each: name, vertices s, modes r, rest (3s), fields (r x 3s), scales (r numbers where
//           the fields are whole), corners (3t), groups (s, of smooth shapes that are split)
//   bodies  of each: name, shape, bones b, scenery, q (f x r), poses (f x b x 7, or b x 7 of a body
//           at rest: position x y z, rotation x y z w), weights (s x b on bones)
// Arrays are {"type": "float32" | "int16" | "uint32", "data": base64}, little-endian.
// position_error: the largest distance, over all bodies and at most 64 frames, between the page's X
// + U q and the exact one, relative to the shape's size.
struct PageMotion {
  std::string json;
  double position_error = 0.0;
};

// Errors: check_animation's; kContent for more coordinates or bones than a page draws.
Result<PageMotion> page_motion(const Animation& animation, bool z_up = true);

// Writes a page with the film alone; its title is the file's name. Errors: page_motion's; kSystem.
Result<WrittenFile> write_motion_page(const std::string& path, const Animation& animation,
                                      bool z_up = true);

}  // namespace tremolo
