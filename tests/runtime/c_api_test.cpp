#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/body.h"
#include "runtime/tremolo.h"
#include "tests/support/dynamics.h"

extern "C" int tremolo_c_round_trip(const char* path);

namespace tremolo {
namespace {

testing::StrainModel c_strain_model() {
  return testing::random_strain_model(testing::spread_omega(4, 5.0, 900.0), 0.3, 71);
}

bool error_names(const char* word) {
  return std::strstr(tremolo_last_error(), word) != nullptr;
}

class CApi : public ::testing::Test {
 protected:
  void SetUp() override {
    bytes_ = *encode_basis(testing::sample_basis(c_strain_model()));
    ASSERT_EQ(tremolo_model_load_memory(bytes_.data(), bytes_.size(), 0, &model_), TREMOLO_OK)
        << tremolo_last_error();
    tremolo_body_options_init(&options_);
    ASSERT_EQ(tremolo_body_create(model_, &options_, &body_), TREMOLO_OK) << tremolo_last_error();
  }
  void TearDown() override {
    tremolo_body_destroy(body_);
    tremolo_model_release(model_);
  }

  // Status of creating a body with the options as they are now.
  tremolo_status create() {
    tremolo_body* other = nullptr;
    const tremolo_status status = tremolo_body_create(model_, &options_, &other);
    tremolo_body_destroy(other);
    return status;
  }

  std::vector<std::byte> bytes_;
  tremolo_model* model_ = nullptr;
  tremolo_body* body_ = nullptr;
  tremolo_body_options options_;
};

TEST_F(CApi, RoundTripFromC) {
  const std::string path = ::testing::TempDir() + "c_api_test.tremolo";
  ASSERT_TRUE(write_basis(path, testing::sample_basis(c_strain_model())));
  EXPECT_EQ(tremolo_c_round_trip(path.c_str()), 0)
      << "line of c_api_test.c; " << tremolo_last_error();
  std::filesystem::remove(path);
}

TEST_F(CApi, StepsAreThoseOfTheEngine) {
  Result<Body> body = Body::create(testing::make_model(c_strain_model()), "ep4", {});
  const double force[3] = {1.0, 2.0, 3.0};
  ASSERT_TRUE(body->apply_force(5, {1.0, 2.0, 3.0}, 3));
  ASSERT_EQ(tremolo_body_apply_force(body_, 5, force, 3), TREMOLO_OK);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(body->step().converged);
  ASSERT_EQ(tremolo_body_step(body_, 20, nullptr), TREMOLO_OK);
  Eigen::VectorXd q(4), p(4);
  ASSERT_EQ(tremolo_body_state(body_, q.data(), p.data(), 4), TREMOLO_OK);
  EXPECT_EQ(q, body->state().q);
  EXPECT_EQ(p, body->state().p);
}

TEST_F(CApi, DampingRatiosAreThoseOfTheEngine) {
  IntegratorOptions options;
  options.ratios.of_modes = {0.02, 0.05};
  Result<Body> body = Body::create(testing::make_model(c_strain_model()), "ep4", options);
  tremolo_body_options given;
  tremolo_body_options_init(&given);
  EXPECT_EQ(given.damping_ratio, nullptr);
  given.damping_ratio = "2%,5%";
  tremolo_body *made = nullptr, *refused = nullptr;
  ASSERT_EQ(tremolo_body_create(model_, &given, &made), TREMOLO_OK) << tremolo_last_error();
  const double force[3] = {1.0, 2.0, 3.0};
  ASSERT_EQ(tremolo_body_apply_force(made, 5, force, 3), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_apply_force(body_, 5, force, 3), TREMOLO_OK);
  ASSERT_TRUE(body->apply_force(5, {1.0, 2.0, 3.0}, 3));
  ASSERT_EQ(tremolo_body_set_damping_ratio(body_, "0.02,0.05"), TREMOLO_OK);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(body->step().converged);
  for (tremolo_body* one : {made, body_}) {
    ASSERT_EQ(tremolo_body_step(one, 20, nullptr), TREMOLO_OK);
    Eigen::VectorXd q(4);
    ASSERT_EQ(tremolo_body_state(one, q.data(), nullptr, 4), TREMOLO_OK);
    EXPECT_EQ(q, body->state().q);
  }
  tremolo_body_destroy(made);
  for (const auto& [text, status] : {std::pair{"2%,", TREMOLO_USAGE},
                                     {"-1%", TREMOLO_CONTENT},
                                     {"nan", TREMOLO_CONTENT},
                                     {"1,0.1", TREMOLO_CONTENT},
                                     {"1%,1%,1%,1%,1%", TREMOLO_CONTENT}}) {
    given.damping_ratio = text;
    EXPECT_EQ(tremolo_body_create(model_, &given, &refused), status) << text;
    EXPECT_EQ(tremolo_body_set_damping_ratio(body_, text), status) << text;
  }
  given.damping_ratio = "2%";
  given.alpha = 1.0;
  EXPECT_EQ(tremolo_body_create(model_, &given, &refused), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_damping_ratio(body_, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_damping_ratio(nullptr, "2%"), TREMOLO_USAGE);
}

TEST_F(CApi, StateSurvivesARoundTrip) {
  const Eigen::VectorXd q = testing::random_vector(4, 0.1, 1),
                        p = testing::random_vector(4, 1.0, 2);
  ASSERT_EQ(tremolo_body_set_state(body_, q.data(), p.data(), 4), TREMOLO_OK);
  Eigen::VectorXd q_read(4), p_read(4);
  ASSERT_EQ(tremolo_body_state(body_, q_read.data(), p_read.data(), 4), TREMOLO_OK);
  EXPECT_EQ(q, q_read);
  EXPECT_EQ(p, p_read);
  EXPECT_EQ(tremolo_body_state(body_, q_read.data(), nullptr, 4), TREMOLO_OK);
}

TEST_F(CApi, ModelTellsItsSizesFrequenciesAndIds) {
  EXPECT_EQ(tremolo_model_modes(model_), 4u);
  EXPECT_EQ(tremolo_model_surface_vertices(model_), 5u);
  EXPECT_EQ(tremolo_model_triangles(model_), 3u);
  double frequencies[4];
  ASSERT_EQ(tremolo_model_frequencies(model_, frequencies, 4), TREMOLO_OK);
  EXPECT_NEAR(frequencies[0], 5.0 / (2.0 * M_PI), 1e-15);
  std::uint32_t ids[5];
  ASSERT_EQ(tremolo_model_surface_ids(model_, ids, 5), TREMOLO_OK);
  EXPECT_EQ(ids[4], 6u);
  tremolo_model* coarse = nullptr;
  ASSERT_EQ(tremolo_model_load_memory(bytes_.data(), bytes_.size(), 2, &coarse), TREMOLO_OK);
  EXPECT_EQ(tremolo_model_modes(coarse), 2u);
  tremolo_model_release(coarse);
}

TEST_F(CApi, NullIsAUsageErrorEverywhere) {
  double d[15] = {};
  float f[15] = {};
  std::uint32_t u[15] = {};
  tremolo_model* model = nullptr;
  tremolo_body* body = nullptr;
  EXPECT_EQ(tremolo_model_load(nullptr, 0, &model), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_load("x", 0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_load_memory(nullptr, 9, 0, &model), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_load_memory(d, 9, 0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_frequencies(nullptr, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_frequencies(model_, nullptr, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_triangle_corners(nullptr, u, 9), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_triangle_corners(model_, nullptr, 9), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_surface_ids(nullptr, u, 5), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_surface_ids(model_, nullptr, 5), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_create(nullptr, nullptr, &body), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_create(model_, nullptr, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_apply_force(nullptr, 0, d, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_apply_force(body_, 0, nullptr, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_clear_forces(nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_step(nullptr, 1, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_state(nullptr, d, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_state(body_, nullptr, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_state(nullptr, d, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_state(body_, nullptr, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_state(body_, d, nullptr, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_positions_float(nullptr, f, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_positions_float(body_, nullptr, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_surface_float(nullptr, f, f, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_surface_float(body_, nullptr, f, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_surface_float(body_, f, nullptr, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_positions_double(nullptr, d, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_positions_double(body_, nullptr, 15), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_energy(nullptr, d, d, d), TREMOLO_USAGE);
  EXPECT_TRUE(error_names("the body is NULL")) << tremolo_last_error();
  EXPECT_EQ(tremolo_model_modes(nullptr), 0u);
  EXPECT_EQ(tremolo_model_surface_vertices(nullptr), 0u);
  EXPECT_EQ(tremolo_model_triangles(nullptr), 0u);
  EXPECT_EQ(tremolo_body_time(nullptr), 0.0);
  tremolo_model_release(nullptr);
  tremolo_body_destroy(nullptr);
  tremolo_body_options_init(nullptr);
  EXPECT_EQ(model, nullptr);
  EXPECT_EQ(body, nullptr);
}

TEST_F(CApi, LengthThatDoesNotFitIsAUsageErrorThatSaysBoth) {
  double d[16] = {};
  float f[16] = {};
  std::uint32_t u[16] = {};
  EXPECT_EQ(tremolo_body_positions_double(body_, d, 16), TREMOLO_USAGE);
  EXPECT_TRUE(error_names("16") && error_names("15")) << tremolo_last_error();
  EXPECT_EQ(tremolo_body_positions_float(body_, f, 14), TREMOLO_USAGE);
  float normals[15] = {};
  EXPECT_EQ(tremolo_body_surface_float(body_, f, normals, 14), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_surface_float(body_, f, normals, 15), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_state(body_, d, d, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_state(body_, d, d, 5), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_frequencies(model_, d, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_triangle_corners(model_, u, 8), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_surface_ids(model_, u, 6), TREMOLO_USAGE);
}

TEST_F(CApi, LoadingTellsWhatIsWrongWithTheFile) {
  tremolo_model* model = nullptr;
  EXPECT_EQ(tremolo_model_load("/no/such/file.tremolo", 0, &model), TREMOLO_SYSTEM);
  EXPECT_TRUE(error_names("/no/such/file.tremolo"));
  const std::string path = ::testing::TempDir() + "c_api_bad.tremolo";
  std::ofstream(path) << "this is no basis";
  EXPECT_EQ(tremolo_model_load(path.c_str(), 0, &model), TREMOLO_CONTENT);
  EXPECT_TRUE(error_names("c_api_bad.tremolo")) << tremolo_last_error();
  std::filesystem::remove(path);
  EXPECT_EQ(tremolo_model_load_memory(bytes_.data(), bytes_.size() - 1, 0, &model),
            TREMOLO_CONTENT);
  EXPECT_EQ(tremolo_model_load_memory(bytes_.data(), bytes_.size(), 5, &model), TREMOLO_USAGE);
  EXPECT_EQ(model, nullptr);
}

TEST_F(CApi, EveryNameOfAnIntegratorMakesABodyThatSteps) {
  std::size_t count = 0;
  for (const char* name = nullptr; (name = tremolo_integrator_name(count)) != nullptr; ++count) {
    EXPECT_EQ(integrator_names()[count], name);
    options_.integrator = name;
    options_.step = 2e-4;  // explicit methods need h omega < 2
    tremolo_body* body = nullptr;
    ASSERT_EQ(tremolo_body_create(model_, &options_, &body), TREMOLO_OK)
        << name << ": " << tremolo_last_error();
    const double force[3] = {0.1, 0.2, 0.3};
    EXPECT_EQ(tremolo_body_apply_force(body, 5, force, 2), TREMOLO_OK) << name;
    std::int64_t done = 0;
    EXPECT_EQ(tremolo_body_step(body, 10, &done), TREMOLO_OK) << name;
    EXPECT_EQ(done, 10) << name;
    double q[4] = {};
    EXPECT_EQ(tremolo_body_state(body, q, nullptr, 4), TREMOLO_OK) << name;
    EXPECT_GT(std::abs(q[0]), 0.0) << name << " did not move";
    tremolo_body_destroy(body);
  }
  EXPECT_EQ(count, integrator_names().size());
  EXPECT_EQ(tremolo_integrator_name(count + 1), nullptr);
  EXPECT_EQ(tremolo_integrator_name(static_cast<std::size_t>(-1)), nullptr);
}

TEST_F(CApi, OptionsAreChecked) {
  options_.integrator = "leapfrog";
  EXPECT_EQ(create(), TREMOLO_USAGE);
  EXPECT_TRUE(error_names("leapfrog") && error_names("imexv"));
  tremolo_body_options_init(&options_);
  options_.split = "half";
  EXPECT_EQ(create(), TREMOLO_USAGE);
  tremolo_body_options_init(&options_);
  options_.step = -1.0;
  EXPECT_EQ(create(), TREMOLO_USAGE);
  tremolo_body_options_init(&options_);
  options_.safety = 2.0;
  EXPECT_EQ(create(), TREMOLO_USAGE);
  tremolo_body_options_init(&options_);
  options_.size = 0;
  EXPECT_EQ(create(), TREMOLO_USAGE);
  tremolo_body_options_init(&options_);
  options_.integrator = nullptr;
  options_.split = nullptr;
  EXPECT_EQ(create(), TREMOLO_OK);
}

TEST_F(CApi, FieldsBeyondTheCallersSizeKeepTheirDefaults) {
  options_.step = -1.0;
  options_.tolerance = -1.0;
  options_.size = offsetof(tremolo_body_options, step);
  EXPECT_EQ(create(), TREMOLO_OK) << tremolo_last_error();
}

TEST_F(CApi, ArgumentsOutOfRangeAreUsageErrors) {
  const double force[3] = {1.0, 0.0, 0.0};
  const double bad_force[3] = {std::nan(""), 0.0, 0.0};
  EXPECT_EQ(tremolo_body_apply_force(body_, 7, force, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_apply_force(body_, 0xffffffffu, force, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_apply_force(body_, 5, force, 0), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_apply_force(body_, 5, bad_force, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_step(body_, -1, nullptr), TREMOLO_USAGE);
  const double q[4] = {std::numeric_limits<double>::infinity(), 0.0, 0.0, 0.0};
  EXPECT_EQ(tremolo_body_set_state(body_, q, q, 4), TREMOLO_USAGE);
}

TEST_F(CApi, StepThatGivesUpIsASolverErrorAndCountsWhatWasDone) {
  options_.max_iterations = 1;
  options_.integrator = "midpoint";
  tremolo_body* body = nullptr;
  ASSERT_EQ(tremolo_body_create(model_, &options_, &body), TREMOLO_OK);
  const double q[4] = {3.0, -2.0, 2.0, 1.0}, p[4] = {500.0, 300.0, -200.0, 100.0};
  ASSERT_EQ(tremolo_body_set_state(body, q, p, 4), TREMOLO_OK);
  std::int64_t done = -1;
  EXPECT_EQ(tremolo_body_step(body, 5, &done), TREMOLO_SOLVER);
  EXPECT_EQ(done, 0);
  EXPECT_TRUE(error_names("did not converge")) << tremolo_last_error();
  double q_after[4];
  ASSERT_EQ(tremolo_body_state(body, q_after, nullptr, 4), TREMOLO_OK);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(q_after[i], q[i]);
  tremolo_body_destroy(body);
}

TEST_F(CApi, BodyThatAForceHasStoppedGoesOnWhenTheForceIsCleared) {
  const double far[3] = {1e308, 1e308, 1e308};
  EXPECT_EQ(tremolo_body_apply_force(body_, 5, far, 1000), TREMOLO_USAGE);
  EXPECT_TRUE(error_names("1e+308 N at vertex 5")) << tremolo_last_error();
  EXPECT_EQ(tremolo_body_step(body_, 3, nullptr), TREMOLO_OK) << tremolo_last_error();
  // Each of these can still be squared, their sum cannot.
  const double great[3] = {1e153, 1e153, 1e153}, none[4] = {};
  for (int k = 0; k < 100; ++k)
    ASSERT_EQ(tremolo_body_apply_force(body_, 5, great, 1000), TREMOLO_OK) << tremolo_last_error();
  EXPECT_EQ(tremolo_body_step(body_, 1, nullptr), TREMOLO_SOLVER);
  EXPECT_TRUE(error_names("overflow under the load")) << tremolo_last_error();
  ASSERT_EQ(tremolo_body_set_state(body_, none, none, 4), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_step(body_, 1, nullptr), TREMOLO_SOLVER);  // the forces are still there
  ASSERT_EQ(tremolo_body_clear_forces(body_), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_step(body_, 100, nullptr), TREMOLO_OK) << tremolo_last_error();
}

TEST_F(CApi, ExplosionIsABoundThatWasLeft) {
  options_.integrator = "verlet";
  options_.step = 3e-3;
  tremolo_body* body = nullptr;
  ASSERT_EQ(tremolo_body_create(model_, &options_, &body), TREMOLO_OK);
  const double q[4] = {0.01, 0.01, 0.01, 0.01}, p[4] = {};
  ASSERT_EQ(tremolo_body_set_state(body, q, p, 4), TREMOLO_OK);
  EXPECT_EQ(tremolo_body_step(body, 1000, nullptr), TREMOLO_BOUND);
  EXPECT_TRUE(error_names("exploded")) << tremolo_last_error();
  double after[4];
  ASSERT_EQ(tremolo_body_state(body, after, nullptr, 4), TREMOLO_OK);
  for (const double value : after) EXPECT_LT(std::abs(value), 10.0);
  tremolo_body_destroy(body);
}

TEST_F(CApi, ErrorMessageBelongsToItsThread) {
  EXPECT_EQ(tremolo_body_step(nullptr, 1, nullptr), TREMOLO_USAGE);
  std::string other = "unset";
  std::thread([&] { other = tremolo_last_error(); }).join();
  EXPECT_EQ(other, "");
  EXPECT_TRUE(error_names("NULL"));
}

}  // namespace
}  // namespace tremolo
