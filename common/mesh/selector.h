// Sets of vertices selected by a short text: where a body is fixed, where it is pushed.
#pragma once

#include <array>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// The grammar, one line, for help and error messages.
inline constexpr const char* kSelectorGrammar =
    "x<V x<=V x>V x>=V (also y, z; metres, or a percentage of the extent: x<10%), "
    "box:X0,Y0,Z0,X1,Y1,Z1 (bounds belong to it), sphere:X,Y,Z,R, plane:X,Y,Z,NX,NY,NZ (a point "
    "and the normal towards the chosen side), near:X,Y,Z[,K] (the K nearest), vertex:ID[,ID...] "
    "(from 0), file:IDS.txt, colour:red or colour:#RRGGBB[,TOLERANCE], none, or the name of a set "
    "of the mesh (set:NAME if it looks like one of these); A and B for what is in both";

// value: metres; or, if `percent`, hundredths of the extent along its axis from its low end. A
// radius counts in hundredths of the bounding box's diagonal then.
struct SelectorLength {
  double value = 0;
  bool percent = false;
};
using SelectorPoint = std::array<SelectorLength, 3>;

struct SelectNone {};
struct SelectHalfSpace {
  enum class Comparison { kLess, kLessEqual, kGreater, kGreaterEqual };
  int axis = 0;  // 0, 1, 2: x, y, z
  Comparison comparison = Comparison::kLess;
  SelectorLength bound;
};
struct SelectBox {
  SelectorPoint low, high;  // inclusive
};
struct SelectSphere {
  SelectorPoint centre;
  SelectorLength radius;  // inclusive
};
// Selects the points on the plane or on the side that the normal points to.
struct SelectPlane {
  SelectorPoint point;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // of length 1
};
struct SelectNear {
  SelectorPoint point;
  std::size_t count = 1;
};
struct SelectVertices {
  std::vector<VertexId> ids;
};
struct SelectFile {
  std::string path;
  std::vector<VertexId> ids;  // empty until a reader of files fills it
};
// tolerance: the largest difference in red, green or blue, 0 to 255.
struct SelectColour {
  Colour colour{};
  int tolerance = 64;
};
struct SelectSet {
  std::string name;
};

// text: as the user wrote it, for messages. further: selectors that must choose a vertex as well.
struct Selector {
  std::string text;
  std::variant<SelectNone, SelectHalfSpace, SelectBox, SelectSphere, SelectPlane, SelectNear,
               SelectVertices, SelectFile, SelectColour, SelectSet>
      choice;
  std::vector<Selector> further;
};

// Errors are kUsage and show the grammar.
Result<Selector> parse_selector(const std::string& text);

// The paths of the `file:` parts; none for a text that is not a selector.
std::vector<std::string> files_of_selector(const Selector& selector);
std::vector<std::string> files_of_selector(const std::string& text);

// True if a selector means a piece of the surface (a colour, a set of the mesh) rather than all
// points in a region.
bool means_surface(const Selector& selector);

// The vertices to select from. All vectors have n entries (colours: or none). unselectable: the
// reason why a vertex with the flag false is not selected, for messages. given: what the numbers of
// `vertex:` and `file:` mean if they are not those of the vertices.
struct SelectionSpace {
  const std::vector<Eigen::Vector3d>& vertices;
  std::vector<bool> selectable;
  const std::map<std::string, std::vector<VertexId>>& sets;
  const std::vector<Colour>& colours;
  const char* unselectable;
  const GivenVertices* given = nullptr;
};

// The vertices that belong to a tetrahedron. Refers to the mesh.
SelectionSpace selection_space(const TetMesh& mesh);

// Ascending ids, without repeats, of selectable vertices. Empty only for `none`: a selector that
// finds no vertex is an error (kContent) that shows the bounding box of the selectable vertices,
// the sets and the most frequent colours. A `near:` whose point is farther away than ten times the
// size of the selectable vertices is kContent. A name that is not a set is kUsage; `vertex:` with
// an id that is out of range or not selectable is kContent.
Result<std::vector<VertexId>> select_vertices(const Selector& selector,
                                              const SelectionSpace& space);
Result<std::vector<VertexId>> select_vertices(const Selector& selector, const TetMesh& mesh);

// Result of one `near:`: count vertices; the nearest is `nearest` from its point and the others are
// up to `farthest` from it, m.
struct NearChoice {
  std::string text;
  std::size_t count = 0;
  VertexId nearest = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the nearest
  double distance = 0;
  double farthest = 0;
};

// One choice for each `near:` in a selector that select_vertices() accepted; empty without any.
std::vector<NearChoice> near_choices(const Selector& selector, const SelectionSpace& space);

// "near:0,0,1: vertex 12 at (0, 0, 0.98) m, 0.02 m from that point". id: the vertex's number for
// the user.
std::string describe_near(const NearChoice& choice, VertexId id);

// "3 vertices from (0, 0, 0) to (1, 1, 0) m: 0 4 7", for the user. places: of the ids, in m.
std::string describe_vertices(const std::vector<VertexId>& ids,
                              const std::vector<Eigen::Vector3d>& places);

}  // namespace tremolo
