#include "runtime/model.h"

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/derived_basis.h"
#include "tests/support/sample_basis.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

BasisData sample(Eigen::Index r = 4) {
  return testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(r, 5.0, 200.0), 0.3, 51));
}

std::string temporary_file(const char* name) {
  return ::testing::TempDir() + name;
}

void expect_same(const Model& model, const BasisData& data, Eigen::Index modes) {
  ASSERT_EQ(model.modes(), modes);
  EXPECT_EQ(model.lambda(), data.lambda.head(modes));
  EXPECT_EQ(model.surface().vertex_ids, data.surface.vertex_ids);
  EXPECT_EQ(model.surface().rows, data.surface.rows.leftCols(modes));
  EXPECT_EQ(model.triangles(), data.triangles);
  EXPECT_EQ(model.default_load().vertices, data.load.vertices);
  EXPECT_EQ(model.vertex_count(), data.vertex_count);
  EXPECT_EQ(model.tetrahedron_count(), data.tetrahedron_count);
  const Result<VertexRows> inside = model.vertex(4);
  ASSERT_TRUE(inside) << inside.error().message;
  EXPECT_EQ(inside->rest, data.interior.rest[1]);
  EXPECT_EQ(inside->rows, data.interior.rows.bottomRows(3).leftCols(modes));
  const Result<VertexRows> outside = model.vertex(5);
  ASSERT_TRUE(outside);
  EXPECT_EQ(outside->rows, data.surface.rows.middleRows(9, 3).leftCols(modes));
}

TEST(Model, HoldsWhatTheBasisHolds) {
  const BasisData data = sample();
  expect_same(**Model::from_data(data), data, 4);
  expect_same(**Model::from_data(data, {.modes = 2}), data, 2);
}

TEST(Model, ALinearModelPullsBackByLambdaAlone) {
  const BasisData data = sample();
  BasisData without = data;
  without.cubic.clear();
  without.quartic.clear();
  const std::string path = temporary_file("linear_model_test.tremolo");
  ASSERT_TRUE(write_basis(path, data));
  const Result<Model::Pointer> models[] = {
      Model::from_data(data, {.linear = true}), Model::load(path, {.linear = true}),
      Model::from_data(without), Model::load_from_memory(*encode_basis(without))};
  const Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(4, -1.0, 2.0);
  for (const Result<Model::Pointer>& model : models) {
    ASSERT_TRUE(model) << model.error().message;
    const Potential& potential = (*model)->potential();
    PotentialWorkspace workspace = potential.make_workspace();
    Evaluation out = potential.make_evaluation();
    potential.evaluate(q, kWantEnergy | kWantForce | kWantTangent, workspace, out);
    EXPECT_EQ(out.force, data.lambda.cwiseProduct(q));
    EXPECT_EQ(out.tangent, Eigen::MatrixXd(data.lambda.asDiagonal()));
    EXPECT_DOUBLE_EQ(out.energy, 0.5 * q.dot(data.lambda.cwiseProduct(q)));
  }
}

TEST(Model, ACompactFileIsTheSameModelButForItsRounding) {
  const BasisData data = sample();
  const std::string path = temporary_file("compact_model_test.tremolo");
  ASSERT_TRUE(write_basis(path, data, BasisEncoding::kCompact));
  for (const int modes : {0, 3}) {
    const Result<Model::Pointer> model = Model::load(path, {.modes = modes});
    ASSERT_TRUE(model) << model.error().message;
    const Eigen::Index r = modes == 0 ? 4 : modes;
    EXPECT_EQ((*model)->lambda(), data.lambda.head(r));
    const double step = data.surface.rows.cwiseAbs().maxCoeff() / 32767.0;
    EXPECT_LE(((*model)->surface().rows - data.surface.rows.leftCols(r)).cwiseAbs().maxCoeff(),
              step);
    EXPECT_EQ((*model)->surface().column_scales.size(), r);
    const Result<VertexRows> inside = (*model)->vertex(4);
    ASSERT_TRUE(inside) << inside.error().message;
    EXPECT_LE((inside->rows - data.interior.rows.bottomRows(3).leftCols(r)).cwiseAbs().maxCoeff(),
              step);
  }
}

TEST(Model, FileMemoryAndDataGiveTheSameModel) {
  const BasisData data = sample();
  const std::string path = temporary_file("model_test.tremolo");
  ASSERT_TRUE(write_basis(path, data));
  for (const int modes : {0, 3}) {
    const Result<Model::Pointer> from_file = Model::load(path, {.modes = modes});
    ASSERT_TRUE(from_file) << from_file.error().message;
    expect_same(**from_file, data, modes == 0 ? 4 : modes);
    std::vector<std::byte> bytes = *encode_basis(data);
    const Result<Model::Pointer> from_memory = Model::load_from_memory(bytes, {.modes = modes});
    ASSERT_TRUE(from_memory) << from_memory.error().message;
    bytes.assign(bytes.size(), std::byte{0xff});  // no longer needed
    expect_same(**from_memory, data, modes == 0 ? 4 : modes);
  }
  std::filesystem::remove(path);
}

TEST(Model, DamagedInteriorMattersOnlyToThoseWhoAskForIt) {
  const std::string path = temporary_file("damaged_interior.tremolo");
  const BasisData data = sample();
  std::vector<std::byte> bytes = *encode_basis(data);
  std::uint64_t at = 0;
  const Result<BasisReader> reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader);
  for (const BasisSection& section : reader->sections())
    if (section.name == basis_layout::kInteriorBasis) at = section.offset;
  ASSERT_GT(at, 0u);
  bytes[at] ^= std::byte{1};
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  const Result<Model::Pointer> model = Model::load(path);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_TRUE((*model)->vertex(5));
  const Result<VertexRows> inside = (*model)->vertex(4);
  ASSERT_FALSE(inside);
  EXPECT_EQ(inside.error().kind, ErrorKind::kContent);
  EXPECT_FALSE(Model::load_from_memory(bytes));
  std::filesystem::remove(path);
}

TEST(Model, InteriorMayBeAskedForByManyThreads) {
  const BasisData data = sample();
  const std::string path = temporary_file("threads.tremolo");
  ASSERT_TRUE(write_basis(path, data));
  const Model::Pointer model = *Model::load(path);
  std::vector<std::thread> threads;
  std::atomic<int> right = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      const Result<VertexRows> rows = model->vertex(1);
      if (rows && rows->rows == data.interior.rows.topRows(3)) ++right;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 4);
  std::filesystem::remove(path);
}

TEST(Model, KnowsItsFrequenciesAndItsExplicitStepLimit) {
  const Model::Pointer model = *Model::from_data(sample());
  EXPECT_NEAR(model->frequencies_hz()[0], 5.0 / (2.0 * std::numbers::pi), 1e-15);
  EXPECT_NEAR(model->explicit_step_limit(), 2.0 / 200.0, 1e-16);
}

TEST(Model, VertexThatDoesNotExistIsAUsageError) {
  const Model::Pointer model = *Model::from_data(sample());
  for (const VertexId id : {-1, 7, 100000}) {
    const Result<VertexRows> rows = model->vertex(id);
    ASSERT_FALSE(rows);
    EXPECT_EQ(rows.error().kind, ErrorKind::kUsage);
    EXPECT_NE(rows.error().message.find(std::to_string(id)), std::string::npos);
  }
}

TEST(Model, LevelOfDetailOutsideTheModelIsAUsageError) {
  EXPECT_EQ(Model::from_data(sample(), {.modes = 5}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(Model::from_data(sample(), {.modes = -1}).error().kind, ErrorKind::kUsage);
}

TEST(Model, DataThatDoNotFitAreRefused) {
  const auto refuses = [](auto spoil) {
    BasisData data = sample();
    spoil(data);
    const Result<Model::Pointer> model = Model::from_data(data);
    return !model && model.error().kind == ErrorKind::kContent && !model.error().message.empty();
  };
  EXPECT_TRUE(refuses([](BasisData& d) { d.lambda[0] = 0.0; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.lambda[0] = 1e9; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.lambda[3] = INFINITY; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.lambda.resize(0); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.cubic.pop_back(); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.quartic.back() = std::nan(""); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.surface.rest.pop_back(); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.surface.rows(2, 1) = std::nan(""); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.surface.rest[1].y() = INFINITY; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.surface.vertex_ids[1] = 0; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.interior.rows.conservativeResize(5, 4); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.triangles[0][2] = 5; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.triangles[0][2] = -1; }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.load.forces.clear(); }));
  EXPECT_TRUE(refuses([](BasisData& d) { d.load.forces[0].x() = std::nan(""); }));
}

TEST(Model, MissingFileIsASystemErrorThatNamesIt) {
  const Result<Model::Pointer> model = Model::load(temporary_file("no_such.tremolo"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, ErrorKind::kSystem);
  EXPECT_NE(model.error().message.find("no_such.tremolo"), std::string::npos);
}

}  // namespace

// A rescaled model is the body of the other material: same energy of a displacement, same mass.

namespace {

TEST(RescaledBasis, HasTheEnergyOfAStifferMaterialForTheSameDisplacement) {
  const BasisData data = testing::tiny_basis();
  const double stiffness = 3.0, density = 7.0;
  const Result<BasisData> made = rescaled(data, stiffness, density);
  ASSERT_TRUE(made) << made.error().message;
  const Eigen::Vector2d q(0.3, -0.02);
  const Eigen::Vector2d other = std::sqrt(density) * q;  // moves the vertices equally
  EXPECT_TRUE((made->surface.rows * other).isApprox(data.surface.rows * q, 1e-14));
  EXPECT_TRUE((made->interior.rows * other).isApprox(data.interior.rows * q, 1e-14));
  const double before = reduced_energy(data.lambda, data.cubic, data.quartic, q).energy;
  const double after = reduced_energy(made->lambda, made->cubic, made->quartic, other).energy;
  EXPECT_NEAR(after, stiffness * before, 1e-13 * stiffness * before);
  EXPECT_NEAR(made->lambda[0], data.lambda[0] * stiffness / density, 1e-12);
  EXPECT_EQ(made->total_mass, 7 * data.total_mass);
}

TEST(RescaledBasis, ByOneIsTheSameAndThereAndBackToo) {
  const BasisData data = testing::tiny_basis();
  const Result<BasisData> same = rescaled(data, 1, 1);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->cubic, data.cubic);
  const Result<BasisData> there = rescaled(data, 2, 4);
  ASSERT_TRUE(there);
  const Result<BasisData> back = rescaled(*there, 0.5, 0.25);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->cubic, data.cubic);  // powers of two
  EXPECT_EQ(back->surface.rows, data.surface.rows);
}

TEST(RescaledBasis, RefusesFactorsThatAreNone) {
  for (const double factor : {0.0, -1.0, std::nan(""), 1e308 * 10}) {
    EXPECT_FALSE(rescaled(testing::tiny_basis(), factor, 1));
    EXPECT_FALSE(rescaled(testing::tiny_basis(), 1, factor));
  }
  EXPECT_FALSE(rescaled(testing::tiny_basis(), 1e308, 1e-10));
}

}  // namespace
}  // namespace tremolo
