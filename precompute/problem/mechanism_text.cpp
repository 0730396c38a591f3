// Messages about parts and pieces that can still move.
#include <algorithm>

#include "common/text.h"
#include "precompute/problem/mechanisms.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::string at(const Eigen::Vector3d& x) {
  return text("%g, %g, %g", x.x(), x.y(), x.z());
}

std::string vertex_at(const TetMesh& mesh, VertexId v) {
  return text("vertex %d at ", static_cast<int>(v)) + at(mesh.vertices[v]);
}

std::string motions(int count) {
  return text(count == 1 ? "%d motion" : "%d motions", count);
}

// Returns "the line through vertex 3 at ... and vertex 8 at ..." or "vertex 3 at ...".
std::string axis(const TetMesh& mesh, const std::vector<VertexId>& vertices) {
  if (vertices.size() == 1) return vertex_at(mesh, vertices[0]);
  return (vertices.size() == 2 ? "the edge between " : "the line through ") +
         vertex_at(mesh, vertices[0]) + " and " + vertex_at(mesh, vertices[1]);
}

std::string describe_piece(const TetMesh& mesh, const Pieces& pieces, int piece) {
  std::vector<VertexId> vertices;
  std::size_t tetrahedra = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    if (pieces.of_tetrahedron[t] == piece) {
      ++tetrahedra;
      vertices.insert(vertices.end(), mesh.tetrahedra[t].begin(), mesh.tetrahedra[t].end());
    }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (VertexId v : vertices) middle += mesh.vertices[v];
  return text("piece %d of %d (%zu vertices, %zu tetrahedra, around ", piece + 1, pieces.count,
              vertices.size(), tetrahedra) +
         at(middle / static_cast<double>(vertices.size())) + ")";
}

std::string describe_joint(const TetMesh& mesh, const Pieces& pieces, const Joint& joint) {
  const bool ball = joint.vertices.size() == 1;
  const bool edge = joint.vertices.size() == 2;
  const std::string on = joint.on < 0 ? "" : text("on piece %d ", joint.on + 1);
  const char* why = joint.on < 0 ? (ball   ? "only that is fixed"
                                    : edge ? "only these are fixed"
                                           : "all that is fixed lies on it")
                                 : (ball ? "a ball joint" : "a hinge");
  return describe_piece(mesh, pieces, joint.piece) + " turns " + on + "about " +
         axis(mesh, joint.vertices) + " (" + why + ": " + motions(joint.motions) + ")";
}

Failure mechanism_failure(const TetMesh& mesh, const Pieces& pieces,
                          const std::vector<Mechanism>& mechanisms) {
  constexpr int kNamed = 4;
  int count = 0, all = 0, named = 0;
  std::string list;
  for (const Mechanism& mechanism : mechanisms) {
    count += mechanism.motions;
    for (const Joint& joint : mechanism.joints) {
      ++all;
      if (named == kNamed) continue;
      ++named;
      list += (list.empty() ? "" : "; ") + describe_joint(mesh, pieces, joint);
    }
  }
  if (all > named) list += text("; and %d more joints", all - named);
  if (all > 1) list += "; " + motions(count) + " in all";
  return Failure(content_error("a part of the mesh moves without strain: " + list +
                               ". Join the pieces by faces, or hold the loose ones with --fix"));
}

// Describes the rigid motions that a part still has. freedom: their number, 1 to 6; held: the
// part's fixed vertices.
std::string describe_freedom(const TetMesh& mesh, int freedom, std::vector<VertexId> held) {
  if (held.empty()) return "3 translations and 3 rotations, as nothing of it is fixed";
  const auto farthest = [&](VertexId from) {
    return *std::max_element(held.begin(), held.end(), [&](VertexId a, VertexId b) {
      return (mesh.vertices[a] - mesh.vertices[from]).squaredNorm() <
             (mesh.vertices[b] - mesh.vertices[from]).squaredNorm();
    });
  };
  const VertexId first = farthest(held.front());
  if (freedom > 1)
    return "rotations about " + vertex_at(mesh, first) +
           (held.size() == 1 ? ", the only fixed one" : ", as all fixed ones are next to it");
  return "rotation about the line through " + vertex_at(mesh, first) + " and " +
         vertex_at(mesh, farthest(first)) + ", as all fixed ones lie on it";
}

std::string describe_part(const TetMesh& mesh, const MeshReport& report, int part) {
  const auto& labels = report.part_of_vertex;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double count = 0;
  for (std::size_t v = 0; v < labels.size(); ++v)
    if (labels[v] == part) {
      middle += mesh.vertices[v];
      ++count;
    }
  return text("part %d of %zu (%.0f vertices around ", part + 1, report.parts, count) +
         at(middle / count) + ")";
}

void require_held(const TetMesh& mesh, const MeshReport& report,
                  const std::vector<VertexId>& fixed) {
  const auto parts = static_cast<int>(report.parts);
  const std::vector<int> freedom = rigid_freedom(mesh, report.part_of_vertex, parts, fixed);
  for (int part = 0; part < parts; ++part) {
    if (freedom[part] == 0) continue;
    std::vector<VertexId> held;
    for (VertexId v : fixed)
      if (report.part_of_vertex[v] == part) held.push_back(v);
    throw Failure(content_error(
        describe_part(mesh, report, part) + " is not held: " + std::to_string(freedom[part]) +
        (freedom[part] == 1 ? " rigid motion is left (" : " rigid motions are left (") +
        describe_freedom(mesh, freedom[part], held) +
        "). Hold it with --fix SELECTOR, or ask for a free body with --fix none"));
  }
}

}  // namespace

void require_no_loose_piece(const TetMesh& mesh, const MeshReport& report,
                            const std::vector<VertexId>& fixed, bool free_body) {
  if (!free_body) require_held(mesh, report, fixed);
  const Pieces pieces = rigid_pieces(mesh);
  if (static_cast<std::size_t>(pieces.count) == report.parts) return;
  const std::vector<Mechanism> mechanisms = find_mechanisms(mesh, report, pieces, fixed, free_body);
  if (!mechanisms.empty()) throw mechanism_failure(mesh, pieces, mechanisms);
}

std::vector<std::string> rigid_motion_notes(const TetMesh& mesh, const MeshReport& report) {
  constexpr int kNamed = 8;
  std::vector<std::string> notes;
  const auto parts = static_cast<int>(report.parts);
  if (parts < 2) return notes;
  for (int part = 0; part < std::min(parts, kNamed); ++part)
    notes.push_back(describe_part(mesh, report, part) +
                    ": 3 translations and 3 rotations are left out");
  if (parts > kNamed) notes.push_back(text("and the same for %d more parts", parts - kNamed));
  return notes;
}

}  // namespace tremolo
