// Assignment of materials to tetrahedra: the option --material, applied to the mesh's regions.
#pragma once

#include <string>
#include <vector>

#include "common/elements/elasticity.h"
#include "common/mesh/selector.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

// Grammar of --material in one line, for help and error messages.
inline constexpr const char* kMaterialGrammar =
    "REGION: young=PA, poisson=NU, density=KG/M3 or, orthotropic, REGION: e1=, e2=, e3=, nu12=, "
    "nu23=, nu31=, g12=, g23=, g31=, axis1=X Y Z, axis2=X Y Z, density=; a selector may stand for "
    "the region; file: the materials of the mesh's file";

// One --material option.
struct MaterialRule {
  std::string where;  // a region's name or a selector; empty: the materials in the mesh file
  Material material;
  Result<Selector> selector = Selector();  // of `where`; an error is reported if it is no region
};

// Parses one --material option. Constants that the text omits are taken from `usual` (--young,
// --poisson, --density); an orthotropic material needs all nine constants, and its axes default to
// x and y. Errors: kUsage for malformed text, kContent for constants that are not admissible.
Result<MaterialRule> parse_material_rule(const std::string& text, const Material& usual);

// Every tetrahedron starts with `usual`, named "default"; the rules are then applied in order, and
// a later rule overrides an earlier one. A selector covers the tetrahedra all of whose vertices it
// selects. Materials that end up without a tetrahedron are dropped. Errors: kUsage for a name that
// is neither a region nor a set (the message lists the regions); kContent for a rule that covers no
// tetrahedron and for materials of the file that are missing or cannot be used.
Result<MaterialTable> assign_materials(const std::vector<MaterialRule>& rules,
                                       const Material& usual, const TetMesh& mesh,
                                       const std::vector<FileMaterial>& of_file);

// Returns for instance "the regions of the mesh are `grip`, `blade`"; names at most twenty.
std::string list_regions(const TetMesh& mesh);

// Number of tetrahedra and volume that a material of the table covers.
struct MaterialShare {
  std::size_t tetrahedra = 0;
  double volume = 0;  // m^3
};
std::vector<MaterialShare> material_shares(const MaterialTable& table, const TetMesh& mesh);

// "E 2e9 Pa, nu 0.3, 1200 kg/m^3"
std::string describe(const Material& material);

}  // namespace tremolo
