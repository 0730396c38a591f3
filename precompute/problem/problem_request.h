// The requested solid as values, before any file is read: texts are parsed, numbers are in SI
// units.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/mesh/selector.h"
#include "common/units.h"
#include "precompute/fem/assembly.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/problem/material_rules.h"
#include "precompute/problem/point_mass.h"

namespace tremolo {

// Refined more often than this a mesh has over 32 768 times its tetrahedra.
inline constexpr int kMostRefine = 5;

// The files of a solid, and how they are read.
struct SolidFiles {
  std::string mesh;                     // tetrahedra, or a surface to be meshed
  std::string render;                   // surface to be drawn; empty: the meshed one, if any
  std::optional<LengthUnit> unit;       // of surfaces, or of tetrahedra if no surface is read
  std::optional<LengthUnit> mesh_unit;  // of tetrahedra, overrides `unit`
  bool merge = false;                   // join vertices of the tetrahedra that lie at one place
  bool y_up = false;                    // the files have y up: rotate them to z up (up_axis.h)
  SurfaceMeshOptions meshing;           // of a surface
};

struct MaterialRequest {
  Material usual;                   // of tetrahedra that no rule covers
  std::vector<MaterialRule> rules;  // in order, a later one overrides
};

struct SupportRequest {
  std::vector<Selector> fixed;
  std::array<std::vector<Selector>, 3> along;  // held along x, y, z only
  // `none` stands alone
  bool free_body() const {
    return fixed.size() == 1 && std::holds_alternative<SelectNone>(fixed.front().choice);
  }
};

std::vector<std::string> texts_of(const std::vector<Selector>& selectors);

struct LoadRequest {
  Selector at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, distributed over the selected vertices
};

struct ElementRequest {
  MassKind mass = MassKind::kConsistent;
  int refine = 0;                 // how often each tetrahedron is cut into eight, 0 to kMostRefine
  std::optional<int> order = 1;   // 1 or 2; none: a rule of the mesh decides
  std::optional<bool> subdivide;  // draw the boundary with edge points; none: where it is coarse
};

struct ProblemRequest {
  SolidFiles files;
  MaterialRequest materials;
  SupportRequest support;
  std::optional<LoadRequest> load;
  std::vector<PointMassRequest> point_masses;
  ElementRequest elements;
  bool imported = false;  // the basis is imported, not computed, and defines the fixed vertices
  unsigned threads = 1;
};

// The same as words of a command line.
struct SolidTexts {
  std::string mesh, render, unit, mesh_unit;
  std::string up = "z";
  bool merge = false;
  SurfaceMeshOptions meshing;
  Material material;
  std::vector<std::string> materials;     // REGION: KEY=VALUE, ... (material_rules.h)
  std::vector<std::string> point_masses;  // SELECTOR=KG
  std::string mass = "consistent";
  std::string order = "auto";
  std::string subdivide = "auto";
  int refine = 0;
  std::vector<std::string> fix;
  std::array<std::vector<std::string>, 3> fix_axis;
  std::string load_at, load_force;
  unsigned threads = 1;
};

// Parses X,Y,Z; returns false if the text is not three numbers.
bool parse_vector(const std::string& text, Eigen::Vector3d& vector);

// Parses the texts and rejects what is wrong for every mesh. loaded: the load is used, and needs a
// force. Throws Failure (kUsage, kContent).
ProblemRequest read_problem_request(const SolidTexts& texts, bool loaded = true);

}  // namespace tremolo
