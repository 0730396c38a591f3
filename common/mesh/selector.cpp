#include "common/mesh/selector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <sstream>
#include <utility>

#include "common/packed_index.h"

namespace tremolo {
namespace {

using Ids = std::vector<VertexId>;

// A point of `near:` that is farther away, over the diagonal of the bounding box, is in another
// unit or mistyped.
constexpr double kMostFar = 10.0;

BoundingBox box_of(const SelectionSpace& space) {
  BoundingBox box;
  bool first = true;
  for (std::size_t v = 0; v < space.vertices.size(); ++v) {
    if (!space.selectable[v]) continue;
    const Eigen::Vector3d& x = space.vertices[v];
    box.low = first ? x : Eigen::Vector3d(box.low.cwiseMin(x));
    box.high = first ? x : Eigen::Vector3d(box.high.cwiseMax(x));
    first = false;
  }
  return box;
}

// m. Hundreds per cent are the high end itself, to the last digit.
double coordinate(const SelectorLength& length, const BoundingBox& box, int axis) {
  if (!length.percent) return length.value;
  const double part = length.value / 100.0;
  return (1.0 - part) * box.low[axis] + part * box.high[axis];
}

Eigen::Vector3d point(const SelectorPoint& given, const BoundingBox& box) {
  return {coordinate(given[0], box, 0), coordinate(given[1], box, 1), coordinate(given[2], box, 2)};
}

template <class Test>
Ids vertices_where(const SelectionSpace& space, const Test& test) {
  Ids ids;
  for (std::size_t v = 0; v < space.vertices.size(); ++v)
    if (space.selectable[v] && test(v)) ids.push_back(static_cast<VertexId>(v));
  return ids;
}

bool holds(SelectHalfSpace::Comparison comparison, double a, double b) {
  switch (comparison) {
    case SelectHalfSpace::Comparison::kLess:
      return a < b;
    case SelectHalfSpace::Comparison::kLessEqual:
      return a <= b;
    case SelectHalfSpace::Comparison::kGreater:
      return a > b;
    case SelectHalfSpace::Comparison::kGreaterEqual:
      return a >= b;
  }
  return false;
}

std::string hex(const Colour& colour) {
  char text[8];
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", colour[0], colour[1], colour[2]);
  return text;
}

std::string describe_sets(const SelectionSpace& space) {
  if (space.sets.empty()) return "it has no named sets";
  std::string text = "its sets are";
  const char* separator = " ";
  for (const auto& [name, ids] : space.sets) {
    text += separator + ("`" + name + "`");
    separator = ", ";
  }
  return text;
}

// The commonest first.
std::string describe_colours(const SelectionSpace& space) {
  std::map<std::string, std::size_t> counts;
  for (std::size_t v = 0; v < space.colours.size(); ++v)
    if (space.selectable[v] && space.colours[v][3] > 0) ++counts[hex(space.colours[v])];
  if (counts.empty()) return "it is not painted";
  std::vector<std::pair<std::size_t, std::string>> sorted;
  for (const auto& [name, count] : counts) sorted.emplace_back(count, name);
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  constexpr std::size_t kShown = 8;
  std::string text = "its colours are";
  const char* separator = " ";
  for (std::size_t i = 0; i < std::min(kShown, sorted.size()); ++i) {
    text += separator + sorted[i].second + " (" + std::to_string(sorted[i].first) + " vertices)";
    separator = ", ";
  }
  if (sorted.size() > kShown) text += " and " + std::to_string(sorted.size() - kShown) + " more";
  return text;
}

std::string describe_box(const BoundingBox& box) {
  std::ostringstream text;
  text << "from (" << box.low.x() << ", " << box.low.y() << ", " << box.low.z() << ") to ("
       << box.high.x() << ", " << box.high.y() << ", " << box.high.z() << ") m";
  return text.str();
}

Error nothing_found(const Selector& selector, const SelectionSpace& space) {
  return content_error("selector `" + selector.text + "` selects no vertex: the mesh extends " +
                       describe_box(box_of(space)) + ", " + describe_sets(space) + " and " +
                       describe_colours(space));
}

Error too_far(const Selector& selector, double distance, const BoundingBox& box) {
  std::ostringstream far;
  far << distance;
  return content_error(
      "selector `" + selector.text + "`: its point is " + far.str() +
      " m away from the nearest vertex: the mesh extends " + describe_box(box) +
      "; coordinates are metres, or a percentage of the extent (near:50%,0%,100%)");
}

Error unknown_set(const Selector& selector, const std::string& name, const SelectionSpace& space) {
  return {ErrorKind::kUsage, "selector `" + selector.text + "`: the mesh has no set `" + name +
                                 "`; " + describe_sets(space) + "; a selector is " +
                                 kSelectorGrammar};
}

// Finds the vertices of one selector; also unselectable ones for ids.
struct Finder {
  const Selector& selector;
  const SelectionSpace& space;
  BoundingBox box;

  Result<Ids> operator()(const SelectNone&) const { return Ids{}; }

  Result<Ids> operator()(const SelectHalfSpace& half) const {
    const double bound = coordinate(half.bound, box, half.axis);
    return vertices_where(space, [&](std::size_t v) {
      return holds(half.comparison, space.vertices[v][half.axis], bound);
    });
  }

  Result<Ids> operator()(const SelectBox& select) const {
    const Eigen::Array3d low = point(select.low, box), high = point(select.high, box);
    return vertices_where(space, [&](std::size_t v) {
      const Eigen::Array3d x = space.vertices[v];
      return (x >= low).all() && (x <= high).all();
    });
  }

  Result<Ids> operator()(const SelectSphere& sphere) const {
    const Eigen::Vector3d centre = point(sphere.centre, box);
    const double radius =
        sphere.radius.percent ? sphere.radius.value / 100.0 * box.diagonal() : sphere.radius.value;
    return vertices_where(
        space, [&](std::size_t v) { return (space.vertices[v] - centre).norm() <= radius; });
  }

  Result<Ids> operator()(const SelectPlane& plane) const {
    const Eigen::Vector3d through = point(plane.point, box);
    // A vertex on an oblique plane is not lost to rounding.
    const double slack = 1e-12 * (box.diagonal() + through.stableNorm());
    return vertices_where(space, [&](std::size_t v) {
      return plane.normal.dot(space.vertices[v] - through) >= -slack;
    });
  }

  Result<Ids> operator()(const SelectNear& near) const {
    const Eigen::Vector3d centre = point(near.point, box);
    if (!centre.allFinite())
      return content_error("selector `" + selector.text +
                           "`: its point is beyond what a number can hold");
    Ids ids = vertices_where(space, [](std::size_t) { return true; });
    const auto nearer = [&](VertexId a, VertexId b) {
      const double x = (space.vertices[a] - centre).squaredNorm();
      const double y = (space.vertices[b] - centre).squaredNorm();
      return x != y ? x < y : a < b;
    };
    const std::size_t count = std::min(near.count, ids.size());
    std::partial_sort(ids.begin(), ids.begin() + count, ids.end(), nearer);
    ids.resize(count);
    if (ids.empty()) return ids;
    const double distance = (space.vertices[ids.front()] - centre).stableNorm();
    if (box.diagonal() > 0 && distance > kMostFar * box.diagonal())
      return too_far(selector, distance, box);
    return ids;
  }

  Result<Ids> operator()(const SelectVertices& list) const {
    const auto who = [this](VertexId id) {
      return "selector `" + selector.text + "`: vertex " + std::to_string(id);
    };
    for (const VertexId id : list.ids) {
      if (space.given != nullptr && !is_index(id, space.given->count))
        return content_error(who(id) + " is not in the surface, whose vertices are 0 to " +
                             std::to_string(space.given->count - 1));
      if (space.given != nullptr) continue;
      if (!is_index(id, space.selectable.size()))
        return content_error(who(id) + " is not in the mesh, whose vertices are 0 to " +
                             std::to_string(space.selectable.size() - 1));
      if (!space.selectable[id]) return content_error(who(id) + " " + space.unselectable);
    }
    return meant_by(list.ids);
  }

  Result<Ids> operator()(const SelectFile& file) const { return meant_by(file.ids); }

  Ids meant_by(const Ids& ids) const {
    return space.given != nullptr ? space.given->meant_by(ids) : ids;
  }

  Result<Ids> operator()(const SelectColour& select) const {
    return vertices_where(space, [&](std::size_t v) {
      if (space.colours.empty() || space.colours[v][3] == 0) return false;
      for (std::size_t channel = 0; channel < 3; ++channel)
        if (std::abs(space.colours[v][channel] - select.colour[channel]) > select.tolerance)
          return false;
      return true;
    });
  }

  Result<Ids> operator()(const SelectSet& set) const {
    const auto found = space.sets.find(set.name);
    if (found == space.sets.end()) return unknown_set(selector, set.name, space);
    return found->second;
  }
};

// Ascending, selectable, without repeats.
Result<Ids> find(const Selector& selector, const SelectionSpace& space) {
  Result<Ids> found = std::visit(Finder{selector, space, box_of(space)}, selector.choice);
  if (!found) return found;
  Ids& ids = *found;
  std::erase_if(ids, [&](VertexId id) {
    return !is_index(id, space.selectable.size()) || !space.selectable[id];
  });
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return found;
}

}  // namespace

SelectionSpace selection_space(const TetMesh& mesh) {
  std::vector<bool> referenced(mesh.vertices.size(), false);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) referenced[v] = true;
  return {mesh.vertices, std::move(referenced),       mesh.node_sets,
          mesh.colours,  "belongs to no tetrahedron", mesh.given.get()};
}

Result<std::vector<VertexId>> select_vertices(const Selector& selector,
                                              const SelectionSpace& space) {
  if (std::holds_alternative<SelectNone>(selector.choice)) return Ids{};
  // A set may be called "head and shoulders".
  if (!selector.further.empty() && space.sets.contains(selector.text))
    return select_vertices({selector.text, SelectSet{selector.text}, {}}, space);
  Result<Ids> ids = find(selector, space);
  if (!ids) return ids;
  for (const Selector& other : selector.further) {
    Result<Ids> more = find(other, space);
    if (!more) return more;
    Ids both;
    std::set_intersection(ids->begin(), ids->end(), more->begin(), more->end(),
                          std::back_inserter(both));
    *ids = std::move(both);
  }
  if (ids->empty()) return nothing_found(selector, space);
  return ids;
}

Result<std::vector<VertexId>> select_vertices(const Selector& selector, const TetMesh& mesh) {
  return select_vertices(selector, selection_space(mesh));
}

std::vector<NearChoice> near_choices(const Selector& selector, const SelectionSpace& space) {
  std::vector<NearChoice> choices;
  const BoundingBox box = box_of(space);
  const auto look = [&](const Selector& one) {
    const auto* near = std::get_if<SelectNear>(&one.choice);
    if (near == nullptr) return;
    const Result<Ids> ids = Finder{one, space, box}(*near);
    if (!ids || ids->empty()) return;
    const Eigen::Vector3d centre = point(near->point, box);
    const auto away = [&](VertexId v) { return (space.vertices[v] - centre).stableNorm(); };
    const VertexId nearest = ids->front();
    choices.push_back({one.text, ids->size(), nearest, space.vertices[nearest], away(nearest),
                       away(ids->back())});
  };
  look(selector);
  for (const Selector& other : selector.further) look(other);
  return choices;
}

std::string describe_near(const NearChoice& choice, VertexId id) {
  std::ostringstream text;
  text.precision(4);
  text << choice.text << ": ";
  if (choice.count > 1) text << choice.count << " vertices, the nearest ";
  text << "vertex " << id << " at (" << choice.place.x() << ", " << choice.place.y() << ", "
       << choice.place.z() << ") m, " << choice.distance << " m from that point";
  if (choice.count > 1) text << ", the farthest " << choice.farthest << " m";
  return text.str();
}

std::string describe_vertices(const std::vector<VertexId>& ids,
                              const std::vector<Eigen::Vector3d>& places) {
  if (ids.empty()) return "no vertex";
  std::string text = ids.size() == 1 ? "1 vertex " : std::to_string(ids.size()) + " vertices ";
  text += describe_box(bounding_box(places)) + ":";
  for (const VertexId id : ids) text += " " + std::to_string(id);
  return text;
}

bool means_surface(const Selector& selector) {
  return std::holds_alternative<SelectColour>(selector.choice) ||
         std::holds_alternative<SelectSet>(selector.choice) ||
         std::any_of(selector.further.begin(), selector.further.end(), means_surface);
}

}  // namespace tremolo
