// A cube by the precompute, and quantities that bodies in contact keep.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "runtime/contact_body.h"
#include "tests/support/programs.h"

namespace tremolo::testing {

// A body of 1000 kg/m^3, precomputed once for each name. young: Pa. held: what --fix takes.
inline Model::Pointer made_body(const std::string& name, const TetMesh& mesh,
                                const std::string& young, const std::string& held) {
  static const std::string folder = fresh_folder();
  const std::string file = name + ".tremolo";
  if (!std::filesystem::exists(folder + "/" + file)) {
    write_veg(folder + "/body.veg", mesh);
    const ProgramResult made =
        run_program(folder, kPrecompute + "body.veg --threads 1 --order 1 --young " + young +
                                " --poisson 0.3 --density 1000 --fix '" + held +
                                "' --linear-modes 6 --modes 12 -o " + file);
    EXPECT_EQ(made.code, 0) << made.err;
  }
  Result<Model::Pointer> model = Model::load(folder + "/" + file);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

// A cube of 0.1 m and 1 kg with its lowest corner at `corner`.
inline Model::Pointer made_cube(const std::string& name, const Eigen::Vector3d& corner,
                                const std::string& young, const std::string& held) {
  TetMesh mesh = box_mesh({3, 3, 3}, {0.1, 0.1, 0.1});
  for (Eigen::Vector3d& x : mesh.vertices) x += corner;
  return made_body(name, mesh, young, held);
}

// Energy of the body and its contact less the energy put in, J.
inline double balance(const ContactBody& body) {
  return body.energy().total() - body.sums().work + body.sums().dissipated;
}

}  // namespace tremolo::testing
