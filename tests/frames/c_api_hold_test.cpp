// Saving, rays, hands anywhere and pins from C: the same bits as from C++.
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/tremolo.h"
#include "tests/support/c_models.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

class CApiHold : public ::testing::Test {
 protected:
  void SetUp() override {
    model_ = testing::load_cloud_model();
    ASSERT_NE(model_, nullptr) << tremolo_last_error();
    body_ = make();
    ASSERT_NE(body_, nullptr);
  }

  void TearDown() override {
    tremolo_body_destroy(body_);
    tremolo_model_release(model_);
  }

  tremolo_body* make() const {
    tremolo_body_options options;
    tremolo_body_options_init(&options);
    options.frame = TREMOLO_FREE;
    tremolo_body* body = nullptr;
    EXPECT_EQ(tremolo_body_create(model_, &options, &body), TREMOLO_OK) << tremolo_last_error();
    EXPECT_EQ(tremolo_body_set_contact(body, nullptr), TREMOLO_OK) << tremolo_last_error();
    return body;
  }

  tremolo_model* model_ = nullptr;
  tremolo_body* body_ = nullptr;
};

TEST_F(CApiHold, RaysHandsPinsAndDampingAreThoseOfCpp) {
  ContactBody other = testing::make_framed(testing::frame_model(4, true, 60.0, 300.0, 0.2, 3),
                                           FrameKind::kFree, {});
  ASSERT_TRUE(other.set_contact());
  const Vector3d corner = *other.position(1);
  const Vector3d middle =
      (*other.position(0) + *other.position(1) + *other.position(2)) / 3.0 * 0.2 + 0.8 * corner;
  const double origin[] = {middle.x() + 0.01, middle.y() - 0.02, middle.z() + 0.01};
  const double direction[] = {-0.01, 0.02, -0.01};
  tremolo_hit hit;
  ASSERT_EQ(tremolo_body_pick(body_, origin, direction, &hit), TREMOLO_OK) << tremolo_last_error();
  const auto found = other.pick(Vector3d(origin), Vector3d(direction));
  ASSERT_TRUE(found);
  ASSERT_TRUE(*found);
  EXPECT_EQ(hit.found, 1);
  EXPECT_EQ(hit.triangle, (*found)->place.triangle);
  EXPECT_EQ(hit.vertex, static_cast<uint32_t>((*found)->vertex));
  EXPECT_EQ(hit.distance, (*found)->distance);
  EXPECT_EQ(Vector3d(hit.weights), (*found)->place.weights);
  EXPECT_EQ(Vector3d(hit.point), (*found)->point);
  uint64_t hand = 0, pin = 0, held = 0;
  ASSERT_EQ(tremolo_body_grab_at(body_, hit.triangle, hit.weights, 300.0, 1.0, &hand), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_pin(body_, 5, &pin), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_pin_at(body_, 1, hit.weights, &held), TREMOLO_OK);
  ASSERT_TRUE(other.grab((*found)->place, 300.0, 1.0));
  ASSERT_TRUE(other.pin(VertexId{5}));
  ASSERT_TRUE(other.pin(SurfacePlace{SurfaceKind::kDrawn, 1, (*found)->place.weights}));
  const double to[] = {0.1, 0.2, 0.3}, gravity[] = {0.0, 0.0, -9.81};
  ASSERT_EQ(tremolo_body_move_hand(body_, hand, to), TREMOLO_OK);
  ASSERT_TRUE(other.move_hand(hand, Vector3d(to)));
  ASSERT_EQ(tremolo_body_set_gravity(body_, gravity), TREMOLO_OK);
  ASSERT_TRUE(other.set_gravity(Vector3d(gravity)));
  ASSERT_EQ(tremolo_body_step(body_, 20, nullptr), TREMOLO_OK) << tremolo_last_error();
  testing::steps_of(other, 20);
  ASSERT_EQ(tremolo_body_set_damping(body_, 0.1, 2e-3), TREMOLO_OK);
  ASSERT_TRUE(other.set_damping(0.1, 2e-3));
  ASSERT_EQ(tremolo_body_step(body_, 20, nullptr), TREMOLO_OK);
  testing::steps_of(other, 20);
  std::vector<double> q(4);
  ASSERT_EQ(tremolo_body_state(body_, q.data(), nullptr, 4), TREMOLO_OK);
  for (Eigen::Index i = 0; i < 4; ++i) EXPECT_EQ(q[i], other.state().q[i]);
  const double away[] = {0.0, 0.0, 50.0}, up[] = {0.0, 0.0, 1.0}, nowhere[] = {0.0, 0.0, 0.0};
  ASSERT_EQ(tremolo_body_pick(body_, away, up, &hit), TREMOLO_OK);
  EXPECT_EQ(hit.found, 0);
  EXPECT_EQ(tremolo_body_pick(body_, away, nowhere, &hit), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_pick(body_, away, nullptr, &hit), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_pin(body_, 99, &pin), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_grab_at(body_, 9, to, 1.0, 0.0, &hand), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_body_set_damping(body_, -1.0, 0.0), TREMOLO_USAGE);
}

TEST_F(CApiHold, SavedBodiesGoOn) {
  uint64_t pin = 0;
  const double force[] = {3.0, 2.0, -5.0};
  ASSERT_EQ(tremolo_body_pin(body_, 5, &pin), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_apply_force(body_, 4, force, 30), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_step(body_, 10, nullptr), TREMOLO_OK);
  size_t size = 0;
  ASSERT_EQ(tremolo_body_save(body_, nullptr, 0, &size), TREMOLO_OK);
  std::vector<unsigned char> bytes(size);
  EXPECT_EQ(tremolo_body_save(body_, bytes.data(), size - 1, &size), TREMOLO_USAGE);
  ASSERT_EQ(tremolo_body_save(body_, bytes.data(), bytes.size(), &size), TREMOLO_OK);
  tremolo_body* fresh = make();
  ASSERT_EQ(tremolo_body_restore(fresh, bytes.data(), bytes.size()), TREMOLO_OK)
      << tremolo_last_error();
  for (tremolo_body* body : {body_, fresh})
    ASSERT_EQ(tremolo_body_step(body, 50, nullptr), TREMOLO_OK);
  std::vector<double> q(4), other(4);
  ASSERT_EQ(tremolo_body_state(body_, q.data(), nullptr, 4), TREMOLO_OK);
  ASSERT_EQ(tremolo_body_state(fresh, other.data(), nullptr, 4), TREMOLO_OK);
  EXPECT_EQ(q, other);
  bytes[bytes.size() / 2] ^= 1U;
  EXPECT_EQ(tremolo_body_restore(fresh, bytes.data(), bytes.size()), TREMOLO_CONTENT);
  EXPECT_NE(std::string(tremolo_last_error()).find("the saved body"), std::string::npos);
  tremolo_body_destroy(fresh);
}

}  // namespace
}  // namespace tremolo
