/* A world from C: a crowd is pushed, moves, is drawn and falls asleep. Called from
 * c_api_crowd_test.cpp; returns 0, or the line that went wrong. */
#include <math.h>
#include <stddef.h>

#include "runtime/tremolo.h"
#include "tests/runtime/c_require.h"

int tremolo_c_world_round(const tremolo_model* model);

enum { kCount = 40 };

int tremolo_c_world_round(const tremolo_model* model) {
  int line = 0;
  int step = 0;
  uint32_t group = 99, coarse = 99, i = 0, bodies[kCount];
  const double force[3] = {1.0, -2.0, 3.0};
  double q[2] = {0.0, 0.0};
  const float* positions = NULL;
  size_t length = 0, updated = 99, failed = 99;
  uint64_t version = 0;
  tremolo_crowd* world = NULL;
  tremolo_body_options method;
  tremolo_group_options options;

  REQUIRE(tremolo_crowd_create(2, &world) == TREMOLO_OK);
  tremolo_body_options_init(&method);
  method.integrator = "imexv-linear";
  method.alpha = 5.0;
  tremolo_group_options_init(&options);
  options.single_precision = 1;
  options.sleep_energy = 1e-2;
  options.sleep_time = 0.1;
  REQUIRE(tremolo_crowd_add_group(world, model, &method, &options, &group) == TREMOLO_OK);
  options.modes = 2;
  REQUIRE(tremolo_crowd_add_group(world, model, &method, &options, &coarse) == TREMOLO_OK);
  for (i = 0; i < kCount; ++i) {
    REQUIRE(tremolo_crowd_add_body(world, group, &bodies[i]) == TREMOLO_OK);
    REQUIRE(tremolo_crowd_set_shown(world, bodies[i], i % 2 == 0) == TREMOLO_OK);
  }
  REQUIRE(tremolo_crowd_awake(world) == 0);
  REQUIRE(tremolo_crowd_update_surfaces(world, &updated) == TREMOLO_OK && updated == kCount / 2);
  for (i = 0; i < 4; ++i)
    REQUIRE(tremolo_crowd_apply_force(world, bodies[i], 5, force, 3) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_move_body(world, bodies[0], coarse) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_awake(world) == 4);
  for (step = 0; step < 10; ++step)
    REQUIRE(tremolo_crowd_step(world, NULL, 0, &failed) == TREMOLO_OK && failed == 0);
  REQUIRE(tremolo_crowd_update_surfaces(world, &updated) == TREMOLO_OK && updated == 2);
  REQUIRE(tremolo_crowd_surface(world, bodies[2], &positions, &length, &version) == TREMOLO_OK);
  REQUIRE(length == 3 * tremolo_model_surface_vertices(model) && version == 2);
  for (i = 0; i < length; ++i) REQUIRE(isfinite(positions[i]));
  REQUIRE(tremolo_crowd_state(world, bodies[0], q, NULL, 2) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_set_state(world, bodies[0], q, q, 2) == TREMOLO_OK);
  for (step = 0; step < 3000 && tremolo_crowd_awake(world) > 0; ++step)
    REQUIRE(tremolo_crowd_step(world, NULL, 0, NULL) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_awake(world) == 0);
  REQUIRE(tremolo_crowd_wake(world, bodies[1]) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_sleep(world, bodies[1]) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_remove_body(world, bodies[1]) == TREMOLO_OK);
  REQUIRE(tremolo_crowd_wake(world, bodies[1]) == TREMOLO_USAGE);

done:
  tremolo_crowd_destroy(world);
  return line;
}
