// A report as a page: one file that needs no other and no network, with the scripts that draw it.
#pragma once

#include <string>
#include <string_view>

namespace tremolo {

// report: an object as JSON, which page.html's scripts show:
//
//     {"title": text, "subtitle": text, "sections": [{"title": text, "parts": [part, ...]}, ...]}
//     part: {"kind": kind, kind: value}
//
// kind is `heading` or `paragraph` (a text), `table` ({columns, rows, caption}), `criteria`,
// `charts` ({charts, columns, height, caption, linked}), `cells`, or `film` (motion.h). In texts
// `code` stands between backticks; nothing is read as HTML, whatever it says.
std::string page_document(std::string_view report);

}  // namespace tremolo
