/* A render surface from C: what a program needs to draw it. Called from render_test.cpp; returns 0,
 * or the line that went wrong. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/tremolo.h"
#include "tests/runtime/c_require.h"

int tremolo_c_render_round(const tremolo_model* model);

int tremolo_c_render_round(const tremolo_model* model) {
  int line = 0;
  const size_t s = tremolo_model_surface_vertices(model);
  const size_t t = tremolo_model_triangles(model);
  const double force[3] = {1.0, 0.0, 0.0};
  size_t i = 0;
  tremolo_body* body = NULL;
  float* positions = malloc(3 * s * sizeof(*positions));
  float* normals = malloc(3 * s * sizeof(*normals));
  float* uvs = malloc(2 * s * sizeof(*uvs));
  uint8_t* colours = malloc(4 * s);
  uint32_t* corners = malloc(3 * t * sizeof(*corners));
  uint32_t* materials = malloc(t * sizeof(*materials));
  uint32_t* objects = malloc(t * sizeof(*objects));
  uint32_t* ids = malloc(s * sizeof(*ids));

  REQUIRE(positions && normals && uvs && colours && corners && materials && objects && ids);
  REQUIRE(tremolo_model_has_render(model) && tremolo_model_has_uvs(model) &&
          tremolo_model_has_colours(model));
  REQUIRE(tremolo_model_triangle_corners(model, corners, 3 * t) == TREMOLO_OK);
  for (i = 0; i < 3 * t; ++i) REQUIRE(corners[i] < s);
  REQUIRE(tremolo_model_uvs(model, uvs, 2 * s) == TREMOLO_OK);
  REQUIRE(tremolo_model_colours(model, colours, 4 * s) == TREMOLO_OK && colours[3] == 255);
  REQUIRE(tremolo_model_materials(model) == 2 && tremolo_model_objects(model) == 2);
  REQUIRE(strcmp(tremolo_model_material_name(model, 1), "seam") == 0);
  REQUIRE(strcmp(tremolo_model_object_name(model, 0), "below") == 0);
  REQUIRE(tremolo_model_object_name(model, 2) == NULL);
  REQUIRE(tremolo_model_triangle_materials(model, materials, t) == TREMOLO_OK);
  REQUIRE(tremolo_model_triangle_objects(model, objects, t) == TREMOLO_OK);
  for (i = 0; i < t; ++i) REQUIRE(materials[i] < 2 && objects[i] < 2);
  REQUIRE(tremolo_model_surface_ids(model, ids, s) == TREMOLO_OK);
  REQUIRE(tremolo_body_create(model, NULL, &body) == TREMOLO_OK);
  /* Any vertex of the surface can be pushed by its id. */
  for (i = 0; i < s; ++i) REQUIRE(tremolo_body_apply_force(body, ids[i], force, 1) == TREMOLO_OK);
  REQUIRE(tremolo_body_step(body, 5, NULL) == TREMOLO_OK);
  REQUIRE(tremolo_body_surface_float(body, positions, normals, 3 * s) == TREMOLO_OK);
  for (i = 0; i < 3 * s; ++i) REQUIRE(isfinite(positions[i]) && isfinite(normals[i]));

done:
  free(ids);
  free(objects);
  free(materials);
  free(corners);
  free(colours);
  free(uvs);
  free(normals);
  free(positions);
  tremolo_body_destroy(body);
  return line;
}
