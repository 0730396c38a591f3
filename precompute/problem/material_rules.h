// Which tetrahedra are of which material: what --material says, onto the regions of the mesh.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "formats/mesh/mesh_reader.h"
#include "precompute/fem/elasticity.h"

namespace tremolo {

// One line, for help and error messages.
inline constexpr const char* kMaterialGrammar =
    "REGION: young=PA, poisson=NU, density=KG/M3 or, orthotropic, REGION: e1=, e2=, e3=, nu12=, "
    "nu23=, nu31=, g12=, g23=, g31=, axis1=X Y Z, axis2=X Y Z, density=; a selector may stand for "
    "the region; file: the materials of the mesh's file";

// One --material. where: a region's name or a selector; empty: `file`, the file's own materials.
struct MaterialRule {
  std::string where;
  Material material;
};

// What the text leaves out is taken from `usual` (--young, --poisson, --density); an orthotropic
// material needs its nine constants, its axes are x and y unless told. Errors: kUsage for what is
// malformed, kContent for values that are no material.
Result<MaterialRule> parse_material_rule(const std::string& text, const Material& usual);

// All tetrahedra are of `usual`, called "default"; then the rules in their order, the later one
// deciding. A selector takes the tetrahedra all of whose vertices it selects. Materials without a
// tetrahedron are left out. Errors: a name that is neither region nor set (kUsage) lists the
// regions; a rule without a tetrahedron is kContent, as are materials of the file that are not
// there or cannot be used.
Result<MaterialTable> assign_materials(const std::vector<MaterialRule>& rules,
                                       const Material& usual, const TetMesh& mesh,
                                       const std::vector<FileMaterial>& of_file);

// "the regions of the mesh are `grip`, `blade`", the first twenty by name.
std::string list_regions(const TetMesh& mesh);

// What a material of the table is of.
struct MaterialShare {
  std::size_t tetrahedra = 0;
  double volume = 0;  // m^3
};
std::vector<MaterialShare> material_shares(const MaterialTable& table, const TetMesh& mesh);

// "E 2e9 Pa, nu 0.3, 1200 kg/m^3"
std::string describe(const Material& material);

}  // namespace tremolo
