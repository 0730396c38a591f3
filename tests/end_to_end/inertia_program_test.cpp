// The inertia integrals in files that tremolo-precompute makes: the same on several ranks, zero
// where a free body's basis must not move it as a whole, and such that a body's momenta and energy
// are those of its whole mesh.
#include <random>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/body.h"
#include "runtime/bones.h"
#include "tests/support/meshes/mass_points.h"
#include "tests/support/programs.h"
#include "tests/support/same_model.h"

namespace tremolo {
namespace {

using testing::MassPoint;

constexpr double kDensityOfBar = 900.0;

class InertiaProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    mesh_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
    for (Eigen::Vector3d& x : mesh_.vertices) x += Eigen::Vector3d(0.3, -0.2, 0.1);
    write_veg(folder_ + "/bar.veg", mesh_);
  }
  BasisData made(const std::string& arguments, const std::string& name, int ranks = 1) {
    const std::string launcher =
        ranks == 1 ? "" : kMayBeRoot + "mpiexec --oversubscribe -n " + std::to_string(ranks) + " ";
    const ProgramResult result =
        run_program(folder_, launcher + kPrecompute + "bar.veg --threads 1 --density 900 -o " +
                                 name + " " + arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    Result<BasisData> data = read_basis(folder_ + "/" + name);
    EXPECT_TRUE(data) << data.error().message;
    return std::move(*data);
  }
  std::string folder_;
  TetMesh mesh_;
};

// +1 or -1 for each column: an eigenvector's sign is free.
Eigen::VectorXd signs_against(const BasisData& one, const BasisData& other) {
  const BasisRows a = testing::rows_of_file(one), b = testing::rows_of_file(other);
  Eigen::VectorXd signs(a.cols());
  for (Eigen::Index j = 0; j < a.cols(); ++j) signs[j] = a.col(j).dot(b.col(j)) < 0 ? -1.0 : 1.0;
  return signs;
}

TEST_F(InertiaProgram, ThreeRanksGiveTheSameIntegralsAsOne) {
  for (const std::string order : {"1", "2"}) {
    const std::string arguments =
        "--order " + order +
        " --fix 'x<0.301' --linear-modes 4 --modes 8 --point-mass 'x>0.699'=0.2";
    const BasisData one = made(arguments, "one.tremolo"),
                    three = made(arguments, "three.tremolo", 3);
    ASSERT_TRUE(one.inertia && three.inertia);
    const Eigen::VectorXd sign = signs_against(one, three);
    const InertiaIntegrals &a = *one.inertia, &b = *three.inertia;
    // Models of one and several ranks agree to 1e-10 (ranks_program_test.cpp).
    constexpr double kSame = 1e-9;
    EXPECT_NEAR(a.mass, b.mass, 1e-13 * a.mass);
    EXPECT_LE((a.first_moment - b.first_moment).norm(), 1e-13 * a.first_moment.norm());
    EXPECT_LE((a.second_moment - b.second_moment).norm(), 1e-13 * a.second_moment.norm());
    EXPECT_LE((a.linear - b.linear * sign.asDiagonal()).norm(), kSame * a.linear.norm());
    for (Eigen::Index j = 0, pair = 0; j < sign.size(); ++j)
      for (Eigen::Index i = 0; i <= j; ++i, ++pair)
        EXPECT_LE((a.B.col(pair) - sign[i] * sign[j] * b.B.col(pair)).norm(), kSame);
  }
}

TEST_F(InertiaProgram, BonesShareTheInertiaOfAFileThatKeptItsElements) {
  const std::vector<BoneSegment> bones = {{{0.3, -0.1, 0.2}, {0.5, -0.1, 0.2}},
                                          {{0.5, -0.1, 0.2}, {0.7, -0.1, 0.2}}};
  const std::string held = " --fix 'x<0.301' --linear-modes 4 --modes 8";
  const auto skin_of = [&](const std::string& name) {
    Result<Model::Pointer> model = Model::load(folder_ + "/" + name);
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    return skin_near_bones(**model, bones, 0.1);
  };
  EXPECT_TRUE(made("--order 1" + held, "without.tremolo").elements.corners.empty());
  const auto refused = skin_of("without.tremolo");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--keep-elements"), std::string::npos);
  for (const std::string& arguments :
       {std::string("--order 1"), std::string("--order 2"), std::string("--encoding compact")}) {
    const BasisData data = made("--keep-elements " + arguments + held, "kept.tremolo");
    ASSERT_EQ(data.elements.corners.size(), mesh_.tetrahedra.size());
    double mass = 0.0;
    for (const double one : data.elements.masses) mass += one;
    EXPECT_NEAR(mass, data.inertia->mass, 1e-12 * mass);
    const auto skin = skin_of("kept.tremolo");
    ASSERT_TRUE(skin) << arguments << skin.error().message;
    Eigen::Matrix3Xd s = data.inertia->linear.topRows<3>();
    for (const auto& share : (*skin)->shares) s -= share->s;
    EXPECT_LE(s.norm(), 1e-13 * data.inertia->linear.topRows<3>().norm()) << arguments;
    EXPECT_NEAR((*skin)->shares[0]->mass, (*skin)->shares[1]->mass, 0.02 * mass);
  }
  made("--keep-elements --point-mass 'x>0.699'=0.2" + held, "heavy.tremolo");
  const auto heavy = skin_of("heavy.tremolo");
  ASSERT_FALSE(heavy);
  EXPECT_NE(heavy.error().message.find("point masses"), std::string::npos);
}

// Modes and derivatives of both second and third order.
TEST_F(InertiaProgram, ABasisOfAFreeBodyMovesNeitherItsCentreNorTurnsIt) {
  for (const std::string order : {"1", "2"})
    for (const std::string derivatives : {"2", "3"}) {
      const BasisData data =
          made("--fix none --linear-modes 5 --order " + order + " --derivatives " + derivatives,
               "free.tremolo");
      ASSERT_TRUE(data.inertia);
      EXPECT_GT(data.lambda.size(), 15);
      const InertiaIntegrals& integrals = *data.inertia;
      const FrameInertia inertia(integrals, integrals.first_moment / integrals.mass);
      // They are sqrt(m) and sqrt(m) times the length 0.4 m where the basis moves the body.
      const double size = std::sqrt(inertia.mass);
      EXPECT_LE(inertia.s.colwise().norm().maxCoeff(), 1e-9 * size) << order << derivatives;
      EXPECT_LE(inertia.a.colwise().norm().maxCoeff(), 1e-9 * 0.4 * size) << order << derivatives;
    }
}

struct MeshMomenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double kinetic = 0;
};

// Momenta of the mesh's mass, from where each vertex is and how fast: velocity + R (omega x (X - C
// + U q) + U p).
MeshMomenta momenta_of_mesh(const Body& body, const TetMesh& mesh) {
  const State& state = body.state();
  const RigidState rigid = body.rigid_state();
  const Eigen::Matrix3d turn = body.pose().rotation.toRotationMatrix();
  Eigen::Matrix3Xd places(3, mesh.vertices.size());
  Eigen::Matrix3Xd velocities = places;
  for (Eigen::Index v = 0; v < places.cols(); ++v) {
    const Result<VertexRows> vertex = body.model().vertex(static_cast<VertexId>(v));
    EXPECT_TRUE(vertex);
    places.col(v) = *body.position(static_cast<VertexId>(v));
    const Eigen::Vector3d arm = turn.transpose() * (places.col(v) - rigid.centre);
    velocities.col(v) = rigid.velocity + turn * (rigid.spin.cross(arm) + vertex->rows * state.p);
  }
  MeshMomenta sum;
  const auto density = [](std::size_t) { return kDensityOfBar; };
  testing::for_each_mass_point(mesh, density, [&](const MassPoint& point) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
    for (int a = 0; a < point.nodes.count; ++a) {
      const std::size_t at = a;
      x += point.shape[at] * places.col(point.nodes[at]);
      v += point.shape[at] * velocities.col(point.nodes[at]);
    }
    sum.linear += point.mass * v;
    sum.angular += point.mass * x.cross(v);
    sum.kinetic += 0.5 * point.mass * v.squaredNorm();
  });
  return sum;
}

TEST_F(InertiaProgram, MomentaAndEnergyOfAFreeBodyAreThoseOfItsMesh) {
  for (const int order : {1, 2}) {
    made("--fix none --linear-modes 5 --order " + std::to_string(order), "free.tremolo");
    const Result<Model::Pointer> model = Model::load(folder_ + "/free.tremolo");
    ASSERT_TRUE(model);
    Result<Body> body = Body::create(*model, "ep4", {}, FrameKind::kFree);
    ASSERT_TRUE(body) << body.error().message;
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Eigen::VectorXd q((*model)->modes()), p = q;
    for (double& value : q) value = 0.03 * uniform(engine);
    for (double& value : p) value = 2.0 * uniform(engine);
    ASSERT_TRUE(body->set_state(q, p));
    ASSERT_TRUE(body->set_pose({{0.4, -0.7, 1.1}, turn_by({0.8, -1.1, 0.4})}));
    ASSERT_TRUE(body->set_motion({0.5, -0.2, 0.9}, {4.0, -7.0, 3.0}));
    const MeshMomenta mesh = momenta_of_mesh(*body, testing::of_order(mesh_, order));
    EXPECT_LE((body->momentum().linear - mesh.linear).norm(), 1e-9 * mesh.linear.norm()) << order;
    EXPECT_LE((body->momentum().angular - mesh.angular).norm(), 1e-9 * mesh.angular.norm())
        << order;
    EXPECT_NEAR(body->energy().kinetic, mesh.kinetic, 1e-9 * mesh.kinetic) << order;
  }
}

}  // namespace
}  // namespace tremolo
