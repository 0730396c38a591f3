// Sets of vertices chosen by a short text: where a body is held, where it is pushed.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "common/result.h"
#include "common/tet_mesh.h"

namespace tremolo {

// The grammar, one line, for help and error messages.
inline constexpr const char* kSelectorGrammar =
    "x<V x<=V x>V x>=V (also y, z; m), box:X0,Y0,Z0,X1,Y1,Z1 (m, bounds belong to it), "
    "vertex:ID[,ID...] (from 0), file:IDS.txt, none, or the name of a set of the mesh";

struct SelectNone {};
struct SelectHalfSpace {
  enum class Comparison { kLess, kLessEqual, kGreater, kGreaterEqual };
  int axis = 0;  // 0, 1, 2: x, y, z
  Comparison comparison = Comparison::kLess;
  double bound = 0;  // m
};
struct SelectBox {
  BoundingBox box;  // m, inclusive
};
struct SelectVertices {
  std::vector<VertexId> ids;
};
struct SelectFile {
  std::string path;
  std::vector<VertexId> ids;  // empty until somebody who may read files fills it
};
struct SelectSet {
  std::string name;
};

// text: as the user wrote it, for messages.
struct Selector {
  std::string text;
  std::variant<SelectNone, SelectHalfSpace, SelectBox, SelectVertices, SelectFile, SelectSet>
      choice;
};

// Errors are kUsage and show the grammar.
Result<Selector> parse_selector(const std::string& text);

// Ascending ids, without repeats, of vertices that belong to a tetrahedron. Empty only for `none`:
// a selector that finds no vertex is an error (kContent) that shows the bounding box and the sets
// of the mesh. A name that is no set is kUsage; `vertex:` with an id that is out of range or
// belongs to no tetrahedron is kContent.
Result<std::vector<VertexId>> select_vertices(const Selector& selector, const TetMesh& mesh);

}  // namespace tremolo
