/* A world of all four kinds from C, by calls. Called from scene_c_api_test.cpp; each function
 * returns 0, or the line that went wrong. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/tremolo_scene.h"
#include "tests/runtime/c_require.h"

int tremolo_c_scene_by_calls(const char* basis, const char* tets, tremolo_scene** scene);
int tremolo_c_scene_world_round(const tremolo_scene* scene);
int tremolo_c_scene_refusals(const char* tets);

/* The scene of scene_c_api_test.cpp: a table of a reduced and a rigid body, a cube of tetrahedra
 * that falls on them, a sheet over all. */
int tremolo_c_scene_by_calls(const char* basis, const char* tets, tremolo_scene** scene) {
  int line = 0;
  const double half[3] = {0.05, 0.05, 0.05};
  const size_t pins[2] = {0, 6};
  tremolo_model* model = NULL;
  tremolo_collider *box = NULL, *plane = NULL;
  tremolo_scene_body place;
  tremolo_body_options method;
  tremolo_tets_options solid;
  tremolo_cloth_options sheet;
  tremolo_placed_collider floor;

  *scene = NULL;
  REQUIRE(tremolo_scene_create(0.002, scene) == TREMOLO_OK);
  REQUIRE(tremolo_model_load(basis, 0, &model) == TREMOLO_OK);
  REQUIRE(tremolo_collider_box(half, &box) == TREMOLO_OK);
  REQUIRE(tremolo_collider_plane(&plane) == TREMOLO_OK);

  tremolo_scene_body_init(&place);
  place.name = "soft";
  place.position[0] = 0.06;
  place.position[2] = 0.0503;
  tremolo_body_options_init(&method);
  method.frame = TREMOLO_FREE;
  method.beta = 0.001;
  REQUIRE(tremolo_scene_add_reduced(*scene, &place, model, &method, box) == TREMOLO_OK);

  place.name = "hard";
  place.position[0] = -0.06;
  place.friction = 0.5;
  REQUIRE(tremolo_scene_add_rigid(*scene, &place, box, 1.0) == TREMOLO_OK);

  place.name = "cube";
  place.position[0] = 0.01;
  place.position[2] = 0.157;
  place.spin[1] = 1.0;
  place.friction = 0.3;
  tremolo_tets_options_init(&solid);
  solid.file = tets;
  solid.method = "midpoint";
  solid.degree = TREMOLO_TETS_QUADRATIC;
  REQUIRE(tremolo_scene_add_tets(*scene, &place, &solid) == TREMOLO_OK);

  tremolo_scene_body_init(&place);
  place.name = "sheet";
  place.velocity[2] = -0.1;
  tremolo_cloth_options_init(&sheet);
  sheet.columns = sheet.rows = 7;
  sheet.width = sheet.height = 0.18;
  sheet.corner[0] = sheet.corner[1] = -0.09;
  sheet.corner[2] = 0.24;
  sheet.stiffness[0] = 200.0;
  sheet.stiffness[1] = 60.0;
  sheet.stiffness[2] = 2.0;
  REQUIRE(tremolo_scene_add_cloth(*scene, &place, "midpoint", &sheet, pins, 2) == TREMOLO_OK);

  tremolo_placed_collider_init(&floor, plane);
  floor.friction = 0.4;
  REQUIRE(tremolo_scene_add_collider(*scene, &floor) == TREMOLO_OK);

done:
  tremolo_model_release(model);
  tremolo_collider_destroy(box);
  tremolo_collider_destroy(plane);
  return line;
}

/* What each kind of body has, and what it refuses. */
int tremolo_c_scene_world_round(const tremolo_scene* scene) {
  enum { kKinds = 4, kMost = 3000 };
  const char* const names[kKinds] = {"soft", "hard", "cube", "sheet"};
  int line = 0, given = 0;
  tremolo_body_id body = 99;
  uint32_t i = 0, asleep = 0;
  int32_t sleeps = 9, failed = 9, points = 0;
  int64_t done = 0, contacts = 0;
  size_t k = 0, n = 0, size = 0, again = 0, kept = 0;
  double there[kMost], before[kMost], speed[kMost], force[3], linear[3], place[3], turn[4];
  const double up[3] = {0.0, 0.0, 1.0};
  const double light[3] = {0.0, 0.0, 1e-6}; /* N */
  float near[kMost];
  uint32_t corners[kMost];
  void* bytes = NULL;
  tremolo_body_kind kind = TREMOLO_REDUCED;
  tremolo_energy_account account;
  tremolo_world* world = NULL;

  REQUIRE(tremolo_world_create(scene, 1, &world) == TREMOLO_OK);
  REQUIRE(tremolo_world_bodies(world) == kKinds);
  REQUIRE(tremolo_world_step(world, 40, &done) == TREMOLO_OK && done == 40);
  REQUIRE(tremolo_world_steps(world) == 40);
  REQUIRE(fabs(tremolo_world_time(world) - 0.08) < 1e-12);
  REQUIRE(tremolo_world_save(world, NULL, 0, &size) == TREMOLO_OK && size > 1000);
  bytes = malloc(size);
  REQUIRE(bytes != NULL);
  REQUIRE(tremolo_world_save(world, bytes, size - 1, &kept) == TREMOLO_USAGE);
  REQUIRE(tremolo_world_save(world, bytes, size, &kept) == TREMOLO_OK && kept == size);

  for (i = 0; i < kKinds; ++i) {
    REQUIRE(tremolo_world_find(world, names[i], &body) == TREMOLO_OK);
    REQUIRE(body != 0 && body == tremolo_world_body(world, i));
    REQUIRE(strcmp(tremolo_world_name(world, body), names[i]) == 0);
    REQUIRE(tremolo_world_kind(world, body, &kind) == TREMOLO_OK && kind == i);
    n = 3 * tremolo_world_vertices(world, body);
    REQUIRE(n > 0 && n <= kMost);
    REQUIRE(tremolo_world_positions_double(world, body, there, n) == TREMOLO_OK);
    REQUIRE(tremolo_world_positions_float(world, body, near, n) == TREMOLO_OK);
    REQUIRE(tremolo_world_velocities(world, body, speed, n) == TREMOLO_OK);
    REQUIRE(tremolo_world_positions_double(world, body, there, n - 1) == TREMOLO_USAGE);
    for (k = 0; k < n; ++k) REQUIRE(fabs(there[k] - near[k]) < 1e-6);
    size = 3 * tremolo_world_triangles(world, body);
    REQUIRE(size > 0 && size <= kMost);
    REQUIRE(tremolo_world_triangle_corners(world, body, corners, size) == TREMOLO_OK);
    for (k = 0; k < size; ++k) REQUIRE(3 * corners[k] < n);
    REQUIRE(tremolo_world_account(world, body, &account) == TREMOLO_OK);
    REQUIRE(account.kinetic >= 0.0 && account.potential >= 0.0 && account.contact >= 0.0);
    REQUIRE(account.friction <= 0.0 && account.restitution <= 0.0);
    REQUIRE(fabs(account.remainder) < 1e-6);
    REQUIRE(tremolo_world_momentum(world, body, linear, NULL) == TREMOLO_OK);
    REQUIRE(tremolo_world_contact(world, body, &contacts, NULL, force, &points) == TREMOLO_OK);
    REQUIRE(isfinite(force[2]) && points >= 0);
    REQUIRE(tremolo_world_look(world, body, &sleeps, &failed) == TREMOLO_OK && failed == 0);
    asleep += (uint32_t)sleeps;
    given = i < 2 ? TREMOLO_OK : TREMOLO_USAGE;
    REQUIRE((int)tremolo_world_pose(world, body, place, turn) == given);
    /* The first particle of the sheet is pinned. */
    REQUIRE((int)tremolo_world_apply_force(world, body, 0, up, 1) ==
            (i < 3 ? TREMOLO_OK : TREMOLO_USAGE));
    REQUIRE(tremolo_world_apply_force(world, body, 1, light, 1) == TREMOLO_OK);
    REQUIRE(tremolo_world_apply_force(world, body, 1, up, 0) == TREMOLO_USAGE);
  }
  REQUIRE(contacts >= 0 && asleep == 0);
  REQUIRE(tremolo_world_find(world, "nobody", &body) == TREMOLO_USAGE);
  REQUIRE(tremolo_world_body(world, kKinds) == 0);
  REQUIRE(tremolo_world_name(world, body + 1) == NULL);
  REQUIRE(tremolo_world_vertices(world, body + 1) == 0);
  REQUIRE(tremolo_world_kind(world, body + 1, &kind) == TREMOLO_USAGE);

  /* The velocities are those of the next step, roughly: a particle that hits something turns. */
  n = 3 * tremolo_world_vertices(world, body);
  REQUIRE(tremolo_world_positions_double(world, body, before, n) == TREMOLO_OK);
  REQUIRE(tremolo_world_step(world, 1, NULL) == TREMOLO_OK);
  REQUIRE(tremolo_world_positions_double(world, body, there, n) == TREMOLO_OK);
  for (k = 0; k < n; ++k)
    REQUIRE(fabs(there[k] - before[k] - 0.002 * speed[k]) < 1e-3 + 0.002 * fabs(speed[k]));

  /* Back, and forward again. The forces on vertices are part of the saved state: there were none.
   */
  REQUIRE(tremolo_world_restore(world, bytes, kept) == TREMOLO_OK);
  REQUIRE(tremolo_world_steps(world) == 40);
  REQUIRE(tremolo_world_save(world, NULL, 0, &again) == TREMOLO_OK && again == kept);
  REQUIRE(tremolo_world_restore(world, bytes, kept / 2) == TREMOLO_CONTENT);
  REQUIRE(strlen(tremolo_last_error()) > 0);

done:
  free(bytes);
  tremolo_world_destroy(world);
  return line;
}

int tremolo_c_scene_refusals(const char* tets) {
  int line = 0;
  const double huge[3] = {HUGE_VAL, 0.0, 0.0};
  tremolo_scene* scene = NULL;
  tremolo_world* world = NULL;
  tremolo_collider *ball = NULL, *plane = NULL;
  tremolo_scene_body place;
  tremolo_tets_options solid;

  REQUIRE(tremolo_scene_create(0.002, NULL) == TREMOLO_USAGE);
  REQUIRE(tremolo_scene_create(0.002, &scene) == TREMOLO_OK);
  REQUIRE(tremolo_scene_set_gravity(scene, huge) == TREMOLO_USAGE);
  REQUIRE(tremolo_world_create(scene, 1, &world) == TREMOLO_CONTENT); /* no body */
  REQUIRE(tremolo_collider_sphere(0.1, &ball) == TREMOLO_OK);
  REQUIRE(tremolo_collider_plane(&plane) == TREMOLO_OK);
  tremolo_scene_body_init(&place);
  REQUIRE(tremolo_scene_add_rigid(scene, &place, ball, 1.0) == TREMOLO_USAGE); /* no name */
  place.name = "ball";
  place.quaternion[0] = 2.0;
  REQUIRE(tremolo_scene_add_rigid(scene, &place, ball, 1.0) == TREMOLO_USAGE);
  place.quaternion[0] = 1.0;
  REQUIRE(tremolo_scene_add_rigid(scene, &place, NULL, 1.0) == TREMOLO_USAGE);
  REQUIRE(tremolo_scene_add_rigid(scene, &place, ball, 1.0) == TREMOLO_OK);
  tremolo_tets_options_init(&solid);
  REQUIRE(tremolo_scene_add_tets(scene, &place, &solid) == TREMOLO_USAGE); /* no file */
  solid.file = tets;
  solid.method = "verlet";
  REQUIRE(tremolo_scene_add_tets(scene, &place, &solid) == TREMOLO_USAGE);
  solid.method = NULL;
  REQUIRE(tremolo_scene_add_tets(scene, &place, &solid) == TREMOLO_OK);
  REQUIRE(tremolo_world_create(scene, 1, &world) == TREMOLO_CONTENT);
  REQUIRE(strstr(tremolo_last_error(), "two bodies are called 'ball'") != NULL);
  tremolo_scene_destroy(scene);
  scene = NULL;

  REQUIRE(tremolo_scene_create(0.002, &scene) == TREMOLO_OK);
  REQUIRE(tremolo_scene_add_rigid(scene, &place, ball, 1.0) == TREMOLO_OK);
  place.name = "cloth";
  REQUIRE(tremolo_scene_add_cloth(scene, &place, "rk4", NULL, NULL, 0) == TREMOLO_OK);
  REQUIRE(tremolo_world_create(scene, 1, &world) == TREMOLO_CONTENT);
  REQUIRE(strncmp(tremolo_last_error(), "cloth 'cloth'", 13) == 0);
  tremolo_scene_destroy(scene);
  scene = NULL;

  REQUIRE(tremolo_scene_create(0.002, &scene) == TREMOLO_OK);
  REQUIRE(tremolo_scene_add_rigid(scene, &place, plane, 1.0) == TREMOLO_OK);
  REQUIRE(tremolo_world_create(scene, 1, &world) == TREMOLO_CONTENT); /* a plane */
  tremolo_scene_destroy(scene);
  scene = NULL;
  REQUIRE(tremolo_scene_parse("bodies = 3", "here.toml", &scene) == TREMOLO_CONTENT);
  REQUIRE(strstr(tremolo_last_error(), "here.toml") != NULL);
  REQUIRE(tremolo_scene_read("/there/is/none.toml", &scene) == TREMOLO_SYSTEM);
  REQUIRE(scene == NULL && world == NULL);

done:
  tremolo_scene_destroy(scene);
  tremolo_world_destroy(world);
  tremolo_collider_destroy(ball);
  tremolo_collider_destroy(plane);
  return line;
}
