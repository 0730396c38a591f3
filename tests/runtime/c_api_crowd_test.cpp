#include <cstring>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/tremolo.h"
#include "tests/support/dynamics.h"

extern "C" int tremolo_c_world_round(const tremolo_model* model);

namespace tremolo {
namespace {

class CApiCrowd : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto strain =
        testing::random_strain_model(testing::spread_omega(4, 5.0, 900.0), 0.05, 71);
    const std::vector<std::byte> bytes = *encode_basis(testing::sample_basis(strain));
    ASSERT_EQ(tremolo_model_load_memory(bytes.data(), bytes.size(), 0, &model_), TREMOLO_OK);
    ASSERT_EQ(tremolo_crowd_create(1, &world_), TREMOLO_OK);
    ASSERT_EQ(tremolo_crowd_add_group(world_, model_, nullptr, nullptr, &group_), TREMOLO_OK)
        << tremolo_last_error();
    ASSERT_EQ(tremolo_crowd_add_body(world_, group_, &body_), TREMOLO_OK);
  }
  void TearDown() override {
    tremolo_crowd_destroy(world_);
    tremolo_model_release(model_);
  }

  tremolo_model* model_ = nullptr;
  tremolo_crowd* world_ = nullptr;
  std::uint32_t group_ = 9, body_ = 9;
};

TEST_F(CApiCrowd, RoundFromC) {
  EXPECT_EQ(tremolo_c_world_round(model_), 0)
      << "line of c_api_crowd_test.c; " << tremolo_last_error();
}

TEST_F(CApiCrowd, FailedBodiesAreNamedAndAsBefore) {
  std::uint32_t others[3];
  for (std::uint32_t& other : others)
    ASSERT_EQ(tremolo_crowd_add_body(world_, group_, &other), TREMOLO_OK);
  const double huge[4] = {1e200, 1e200, 1e200, 1e200}, none[4] = {};
  for (const std::uint32_t body : {others[0], others[2]})
    ASSERT_EQ(tremolo_crowd_set_state(world_, body, huge, none, 4), TREMOLO_OK);
  std::uint32_t failed[1] = {77};
  std::size_t count = 0;
  EXPECT_EQ(tremolo_crowd_step(world_, failed, 1, &count), TREMOLO_SOLVER);
  EXPECT_EQ(count, 2u);
  EXPECT_NE(std::strstr(tremolo_last_error(), "numbers overflow"), nullptr) << tremolo_last_error();
  EXPECT_TRUE(failed[0] == others[0] || failed[0] == others[2]);
  EXPECT_EQ(tremolo_crowd_awake(world_), 0u);
  double q[4];
  ASSERT_EQ(tremolo_crowd_state(world_, others[0], q, nullptr, 4), TREMOLO_OK);
  EXPECT_EQ(q[3], 1e200);
  EXPECT_EQ(tremolo_crowd_step(world_, failed, 1, &count), TREMOLO_OK);
  EXPECT_EQ(count, 0u);
}

TEST_F(CApiCrowd, ForcesCanBeClearedAndEnergiesRead) {
  const double force[3] = {1.0, 2.0, 3.0}, great[3] = {1e150, 1e150, 1e150};
  double kinetic = -1.0, potential = -1.0, high_band = -1.0;
  ASSERT_EQ(tremolo_crowd_apply_force(world_, body_, 5, force, 2), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_clear_forces(world_, body_), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_step(world_, nullptr, 0, nullptr), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_energy(world_, body_, &kinetic, &potential, &high_band), TREMOLO_OK);
  EXPECT_EQ(kinetic + potential + high_band, 0.0);
  ASSERT_EQ(tremolo_crowd_apply_force(world_, body_, 5, force, 2), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_step(world_, nullptr, 0, nullptr), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_energy(world_, body_, &kinetic, &potential, nullptr), TREMOLO_OK);
  EXPECT_GT(kinetic, 0.0);
  EXPECT_GT(potential, 0.0);
  ASSERT_EQ(tremolo_crowd_apply_force(world_, body_, 5, great, 2), TREMOLO_OK);
  EXPECT_EQ(tremolo_crowd_step(world_, nullptr, 0, nullptr), TREMOLO_SOLVER);
  EXPECT_NE(std::strstr(tremolo_last_error(), "overflow under the forces"), nullptr)
      << tremolo_last_error();
  ASSERT_EQ(tremolo_crowd_wake(world_, body_), TREMOLO_OK);
  EXPECT_EQ(tremolo_crowd_step(world_, nullptr, 0, nullptr), TREMOLO_OK);
  EXPECT_EQ(tremolo_crowd_clear_forces(world_, 7), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_clear_forces(nullptr, 0), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_energy(world_, 7, &kinetic, &potential, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_energy(nullptr, 0, &kinetic, &potential, nullptr), TREMOLO_USAGE);
}

TEST_F(CApiCrowd, NullAndWrongNumbersAreUsageErrors) {
  double d[4] = {};
  const float* positions = nullptr;
  std::size_t length = 0;
  std::uint32_t id = 0;
  tremolo_crowd* world = nullptr;
  EXPECT_EQ(tremolo_crowd_create(1, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_group(nullptr, model_, nullptr, nullptr, &id), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_group(world_, nullptr, nullptr, nullptr, &id), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_group(world_, model_, nullptr, nullptr, nullptr), TREMOLO_USAGE);
  tremolo_group_options options{};
  EXPECT_EQ(tremolo_crowd_add_group(world_, model_, nullptr, &options, &id), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "tremolo_group_options_init"), nullptr);
  tremolo_group_options_init(&options);
  options.modes = 5;
  EXPECT_EQ(tremolo_crowd_add_group(world_, model_, nullptr, &options, &id), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_body(nullptr, group_, &id), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_body(world_, group_ + 1, &id), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_add_body(world_, group_, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_remove_body(nullptr, body_), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_move_body(nullptr, body_, group_), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_move_body(world_, body_, group_ + 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_apply_force(nullptr, body_, 5, d, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_apply_force(world_, body_, 5, nullptr, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_apply_force(world_, body_, 0xffffffffu, d, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_step(nullptr, nullptr, 0, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_wake(nullptr, body_), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_sleep(nullptr, body_), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_state(nullptr, body_, d, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_state(world_, body_, nullptr, d, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_state(world_, body_, d, d, 3), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_set_state(world_, body_, d, nullptr, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_set_state(world_, body_, d, d, 5), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_set_shown(nullptr, body_, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_update_surfaces(nullptr, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_surface(world_, body_, nullptr, &length, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_surface(world_, body_, &positions, nullptr, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_crowd_surface(world_, body_, &positions, &length, nullptr), TREMOLO_USAGE);
  EXPECT_EQ(positions, nullptr);
  EXPECT_EQ(tremolo_crowd_awake(nullptr), 0u);
  tremolo_crowd_destroy(nullptr);
  tremolo_group_options_init(nullptr);
  EXPECT_EQ(world, nullptr);
}

}  // namespace
}  // namespace tremolo
