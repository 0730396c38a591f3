/* The C header from C: it compiles as C11, and a C program gets through the whole round. Called
 * from c_api_test.cpp; returns 0, or the line that went wrong. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/tremolo.h"
#include "tests/runtime/c_require.h"

int tremolo_c_round_trip(const char* path);

int tremolo_c_round_trip(const char* path) {
  int line = 0;
  size_t i = 0;
  tremolo_model* model = NULL;
  tremolo_body* body = NULL;
  float* positions = NULL;
  double* rest = NULL;
  uint32_t* corners = NULL;
  const double force[3] = {1.0, -2.0, 3.0};
  int64_t done = -1;
  double kinetic = -1.0, potential = -1.0, high_band = -1.0, moved = 0.0;
  tremolo_body_options options;

  REQUIRE(tremolo_model_load(path, 0, &model) == TREMOLO_OK);
  const size_t length = 3 * tremolo_model_surface_vertices(model);
  const size_t corner_count = 3 * tremolo_model_triangles(model);
  REQUIRE(length > 0 && corner_count > 0 && tremolo_model_modes(model) > 0);
  positions = malloc(length * sizeof(*positions));
  rest = malloc(length * sizeof(*rest));
  corners = malloc(corner_count * sizeof(*corners));
  REQUIRE(positions != NULL && rest != NULL && corners != NULL);
  REQUIRE(tremolo_model_triangle_corners(model, corners, corner_count) == TREMOLO_OK);
  for (i = 0; i < corner_count; ++i) REQUIRE(corners[i] < length / 3);

  tremolo_body_options_init(&options);
  options.integrator = "imexv";
  options.alpha = 0.3;
  REQUIRE(tremolo_body_create(model, &options, &body) == TREMOLO_OK);
  tremolo_model_release(model); /* the body keeps what it needs */
  model = NULL;
  REQUIRE(tremolo_body_positions_double(body, rest, length) == TREMOLO_OK);
  REQUIRE(tremolo_body_apply_force(body, 5, force, 2) == TREMOLO_OK);
  REQUIRE(tremolo_body_step(body, 10, &done) == TREMOLO_OK && done == 10);
  REQUIRE(fabs(tremolo_body_time(body) - 10 * options.step) < 1e-12);
  REQUIRE(tremolo_body_positions_float(body, positions, length) == TREMOLO_OK);
  for (i = 0; i < length; ++i) moved += fabs((double)positions[i] - rest[i]);
  REQUIRE(moved > 1e-6);
  REQUIRE(tremolo_body_energy(body, &kinetic, &potential, &high_band) == TREMOLO_OK);
  REQUIRE(kinetic > 0.0 && potential > 0.0 && high_band >= 0.0);
  REQUIRE(strlen(tremolo_version()) >= 5);

  REQUIRE(strcmp(tremolo_integrator_name(0), "verlet") == 0);
  for (i = 0; tremolo_integrator_name(i) != NULL; ++i)
    REQUIRE(strlen(tremolo_integrator_name(i)) > 0);
  REQUIRE(i > 0 && tremolo_integrator_name(i + 1) == NULL);

done:
  free(corners);
  free(rest);
  free(positions);
  tremolo_body_destroy(body);
  tremolo_model_release(model);
  return line;
}
