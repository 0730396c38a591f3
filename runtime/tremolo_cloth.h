/* Cloth from C: sheets of particles and springs, rigid balls, colliders (docs/cloth.md).
 *
 * As in tremolo.h, whose statuses and colliders are used: handles are owned until they are
 * destroyed, NULL may be destroyed, and tremolo_last_error() returns the reason of a failure. Units
 * are SI.
 *
 *   tremolo_cloth_scene_create("implicit-euler", 1.0 / 60, &scene);
 *   tremolo_cloth_options_init(&options);
 *   tremolo_cloth_scene_add(scene, &options, &cloth);
 *   tremolo_cloth_scene_pin(scene, cloth, corners, 2);
 *   tremolo_cloth_create(scene, &world);
 *   for (...) {
 *     tremolo_cloth_step(world);
 *     tremolo_cloth_positions(world, cloth, positions, 3 * tremolo_cloth_particles(world, cloth));
 *   }
 */
#ifndef TREMOLO_CLOTH_H
#define TREMOLO_CLOTH_H

#include <stddef.h>
#include <stdint.h>

#include "tremolo.h"

/* NOLINTBEGIN(readability-identifier-naming) */

#ifdef __cplusplus
extern "C" {
#endif

/* The description of a scene. */
typedef struct tremolo_cloth_scene tremolo_cloth_scene;
/* A simulated scene. */
typedef struct tremolo_cloth_world tremolo_cloth_world;

/* method: one of the names of docs/cloth.md; NULL: "implicit-euler". step: s. Gravity is 9.81 m/s^2
 * downwards along z. */
tremolo_status tremolo_cloth_scene_create(const char* method, double step,
                                          tremolo_cloth_scene** scene);
void tremolo_cloth_scene_destroy(tremolo_cloth_scene* scene);
/* Gravity in m/s^2 and wind in m/s. */
tremolo_status tremolo_cloth_scene_set_gravity(tremolo_cloth_scene* scene, const double gravity[3]);
tremolo_status tremolo_cloth_scene_set_wind(tremolo_cloth_scene* scene, const double wind[3]);

/* A cloth. Fill with tremolo_cloth_options_init. `size` as in tremolo_body_options. file: NULL for
 * a grid of rows x columns particles, numbered row by row; else a mesh of triangles (.obj,
 * .ply). */
typedef struct tremolo_cloth_options {
  uint32_t size;
  uint32_t columns, rows; /* 20, 20 */
  uint32_t reserved;      /* 0 */
  const char* file;       /* NULL */
  double width, height;   /* m, of the grid; 1, 1 */
  double corner[3];       /* m, of the grid's first particle, or added to the file's vertices */
  double along[3];        /* unit vectors at right angles: along the columns' numbers, */
  double across[3];       /* and the rows'; x and y */
  double density;         /* kg/m^2; 0.2 */
  double stiffness[3];    /* N/m: structural, shear, bend; 1000, 300, 20 */
  double damping[3];      /* N s/m; 0.01, 0.01, 0.001 */
  double drag;            /* of the wind, kg/m^3; 1.2 */
  double thickness;       /* m, distance of particles from obstacles; 0.005 */
  double friction;        /* 0.3 */
  double restitution;     /* 0 to 1; 0 */
} tremolo_cloth_options;

void tremolo_cloth_options_init(tremolo_cloth_options* options);

/* cloth (may be NULL) receives its number. */
tremolo_status tremolo_cloth_scene_add(tremolo_cloth_scene* scene,
                                       const tremolo_cloth_options* options, size_t* cloth);
/* Fixes particles at their positions at the start. */
tremolo_status tremolo_cloth_scene_pin(tremolo_cloth_scene* scene, size_t cloth,
                                       const size_t* particles, size_t count);
/* A rigid ball, m, kg, m/s; mass 0: it is fixed. */
tremolo_status tremolo_cloth_scene_add_ball(tremolo_cloth_scene* scene, double radius, double mass,
                                            const double position[3], const double velocity[3]);
/* A fixed collider at its pose (next_position and next_quaternion are not read); copied. */
tremolo_status tremolo_cloth_scene_add_collider(tremolo_cloth_scene* scene,
                                                const tremolo_placed_collider* collider);

/* The scene is not needed after the call. TREMOLO_CONTENT: a value is out of range, or a part
 * starts inside another. TREMOLO_USAGE: the step is beyond the method's limit, which the message
 * gives. */
tremolo_status tremolo_cloth_create(const tremolo_cloth_scene* scene, tremolo_cloth_world** world);
void tremolo_cloth_destroy(tremolo_cloth_world* world);

/* Takes one step. A step that fails leaves everything unchanged. */
tremolo_status tremolo_cloth_step(tremolo_cloth_world* world);
double tremolo_cloth_time(const tremolo_cloth_world* world);            /* s; 0 for NULL */
double tremolo_cloth_stability_limit(const tremolo_cloth_world* world); /* s; infinity: none */

/* 0 for NULL and for a cloth that does not exist. */
size_t tremolo_cloth_particles(const tremolo_cloth_world* world, size_t cloth);
size_t tremolo_cloth_triangles(const tremolo_cloth_world* world, size_t cloth);

/* x y z x y z ..., m and m/s; length must be three times the particles. */
tremolo_status tremolo_cloth_positions(const tremolo_cloth_world* world, size_t cloth, double* out,
                                       size_t length);
tremolo_status tremolo_cloth_velocities(const tremolo_cloth_world* world, size_t cloth, double* out,
                                        size_t length);
tremolo_status tremolo_cloth_set_state(tremolo_cloth_world* world, size_t cloth,
                                       const double* positions, const double* velocities,
                                       size_t length);
/* Three particles per triangle; length must be three times the triangles. */
tremolo_status tremolo_cloth_triangle_corners(const tremolo_cloth_world* world, size_t cloth,
                                              uint32_t* out, size_t length);

/* Grabs a particle: it is held at a point from the next step on, until it is released. */
tremolo_status tremolo_cloth_hold(tremolo_cloth_world* world, size_t cloth, size_t particle,
                                  const double point[3]);
tremolo_status tremolo_cloth_let_go(tremolo_cloth_world* world, size_t cloth, size_t particle);

/* position, m, and quaternion (w, x, y, z); either may be NULL. */
tremolo_status tremolo_cloth_ball(const tremolo_cloth_world* world, size_t ball, double position[3],
                                  double quaternion[4]);

/* Energies of all cloths and balls, J; any may be NULL. */
tremolo_status tremolo_cloth_energy(const tremolo_cloth_world* world, double* kinetic,
                                    double* elastic, double* gravity);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming) */

#endif /* TREMOLO_CLOTH_H */
