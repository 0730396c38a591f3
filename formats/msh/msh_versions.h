// The sections of an MSH file that differ between the versions. The input is positioned after the
// section's name; the Status gives the error with its position.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/result.h"
#include "formats/mesh/mesh_builder.h"
#include "formats/msh/msh_groups.h"
#include "formats/msh/msh_input.h"

namespace tremolo {

// Version 2: groups are tags of the elements. volume_of_tet: the tag of each tetrahedron kept, the
// first if it has several, 0 without one.
Status read_msh2_nodes(MshInput& input, MeshBuilder& builder);
Status read_msh2_elements(MshInput& input, MeshBuilder& builder, MshGroups& groups,
                          std::vector<std::int64_t>& volume_of_tet);

// Version 4.1: groups are tags of the entities, {dimension, tag} -> physical tags.
using MshEntities = std::map<std::pair<int, std::int64_t>, std::vector<std::int64_t>>;
// partitioned: the section is $PartitionedEntities, whose entities are parts of those in $Entities
// and have the groups of the whole.
Status read_msh4_entities(MshInput& input, bool partitioned, MshEntities& entities);
Status read_msh4_nodes(MshInput& input, MeshBuilder& builder);
Status read_msh4_elements(MshInput& input, const MshEntities& entities, MeshBuilder& builder,
                          MshGroups& groups, std::vector<std::int64_t>& volume_of_tet);

}  // namespace tremolo
