// Starts the programs, for tests.
#pragma once

#include <string>

#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/mesh_file.h"
#include "tests/support/run_program.h"

namespace tremolo {

using testing::box_mesh;
using testing::fresh_folder;
using testing::ProgramResult;
using testing::run_program;
using testing::slurp;
using testing::write_veg;

inline const std::string kTremolo = TREMOLO_BIN_DIR "/tremolo ";
inline const std::string kPrecompute = TREMOLO_BIN_DIR "/tremolo-precompute ";
inline const std::string kMesh = TREMOLO_BIN_DIR "/tremolo-mesh ";
// As root, Open MPI needs explicit permission.
inline const std::string kMayBeRoot = "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ";

}  // namespace tremolo
