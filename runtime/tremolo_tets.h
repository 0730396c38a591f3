/* Solids of full tetrahedra from C: bodies that deform, rotate, have contact with each other and
 * with fixed obstacles, and fall asleep (docs/tets.md).
 *
 * As in tremolo.h, whose statuses and colliders are used: handles are owned until they are
 * destroyed, NULL may be destroyed, and tremolo_last_error() returns the reason of a failure. Units
 * are SI.
 *
 *   tremolo_tets_scene_create(1.0 / 60, &scene);
 *   tremolo_tets_options_init(&options);
 *   options.file = "duck.tets";            // tremolo-precompute tets MESH -o duck.tets
 *   tremolo_tets_scene_add(scene, &options, &body);
 *   tremolo_tets_create(scene, &world);
 *   for (...) {
 *     tremolo_tets_step(world);
 *     tremolo_tets_surface(world, body, positions, normals, 3 * tremolo_tets_vertices(world,
 * body));
 *   }
 */
#ifndef TREMOLO_TETS_H
#define TREMOLO_TETS_H

#include <stddef.h>
#include <stdint.h>

#include "tremolo.h"

/* NOLINTBEGIN(readability-identifier-naming) */

#ifdef __cplusplus
extern "C" {
#endif

/* The description of a scene. */
typedef struct tremolo_tets_scene tremolo_tets_scene;
/* A simulated scene. */
typedef struct tremolo_tets_world tremolo_tets_world;

/* step: s, of all bodies. Defaults: gravity is 9.81 m/s^2 downwards along z, bodies sleep after
 * 0.5 s below 5 mm/s, and one thread is used. */
tremolo_status tremolo_tets_scene_create(double step, tremolo_tets_scene** scene);
void tremolo_tets_scene_destroy(tremolo_tets_scene* scene);
tremolo_status tremolo_tets_scene_set_gravity(tremolo_tets_scene* scene,
                                              const double gravity[3]); /* m/s^2 */
/* Bodies that have been slower than speed, m/s, for `time`, s, fall asleep; speed 0: none does. */
tremolo_status tremolo_tets_scene_set_sleep(tremolo_tets_scene* scene, double speed, double time);
/* threads: 1 to 256; no bit of a result depends on it. */
tremolo_status tremolo_tets_scene_set_threads(tremolo_tets_scene* scene, uint32_t threads);

typedef enum tremolo_tets_degree {
  TREMOLO_TETS_LINEAR = 1,
  TREMOLO_TETS_QUADRATIC = 2,
  TREMOLO_TETS_ADAPTIVE = 3 /* each edge chooses its own */
} tremolo_tets_degree;

/* A body. Fill with tremolo_tets_options_init. `size` as in tremolo_body_options. */
typedef struct tremolo_tets_options {
  uint32_t size;
  int32_t degree;         /* a tremolo_tets_degree; TREMOLO_TETS_ADAPTIVE */
  const char* file;       /* of `tremolo-precompute tets`; required */
  const char* method;     /* "bdf2"; the others are in docs/tets.md */
  double position[3];     /* m, of the mesh's frame */
  double quaternion[4];   /* w, x, y, z, of length one to 1e-6 */
  double velocity[3];     /* m/s, of the centre of mass */
  double spin[3];         /* rad/s, about it */
  double alpha;           /* damps the motion relative to the nearest rigid one, 1/s; 0 */
  double beta;            /* Rayleigh's damping by the stiffness, s; 0 */
  double tolerance;       /* of a step's residual over the weight and the forces; 1e-6 */
  double friction;        /* 0.3; of a pair the geometric mean */
  int32_t max_iterations; /* corrections in a step; 20 */
  /* A step that they do not solve is subdivided (0), is accepted (1), or is subdivided without
   * contact, while a step in contact is two corrections (2); 2 */
  int32_t take_unsolved;
  double drag; /* damps the whole motion like a resting medium, 1/s; 0 */
} tremolo_tets_options;

void tremolo_tets_options_init(tremolo_tets_options* options);

/* body (may be NULL) receives its number. */
tremolo_status tremolo_tets_scene_add(tremolo_tets_scene* scene,
                                      const tremolo_tets_options* options, size_t* body);
/* A fixed collider at its pose (next_position, next_quaternion and restitution are not read);
 * copied. */
tremolo_status tremolo_tets_scene_add_collider(tremolo_tets_scene* scene,
                                               const tremolo_placed_collider* collider);

/* Reads the bodies' files; the scene is not needed after the call. TREMOLO_SYSTEM: a file is
 * missing. TREMOLO_CONTENT: a file is damaged, or a value is out of range. */
tremolo_status tremolo_tets_create(const tremolo_tets_scene* scene, tremolo_tets_world** world);
void tremolo_tets_destroy(tremolo_tets_world* world);

/* Takes one step of all bodies. TREMOLO_SOLVER, with the bodies' numbers in the message: these and
 * the bodies in contact with them are unchanged, the others have moved. */
tremolo_status tremolo_tets_step(tremolo_tets_world* world);
double tremolo_tets_time(const tremolo_tets_world* world); /* s; 0 for NULL */

/* 0 for NULL and for a body that does not exist. vertices, triangles: of the drawn surface. points:
 * control points, the mesh's vertices and then its edges. */
size_t tremolo_tets_bodies(const tremolo_tets_world* world);
size_t tremolo_tets_vertices(const tremolo_tets_world* world, size_t body);
size_t tremolo_tets_triangles(const tremolo_tets_world* world, size_t body);
size_t tremolo_tets_points(const tremolo_tets_world* world, size_t body);

/* The drawn surface, x y z x y z ..., m, and its normals, of length one; either may be NULL. length
 * must be three times the vertices. */
tremolo_status tremolo_tets_surface(tremolo_tets_world* world, size_t body, float* positions,
                                    float* normals, size_t length);
/* Three vertices per triangle; length must be three times the triangles. */
tremolo_status tremolo_tets_triangle_corners(const tremolo_tets_world* world, size_t body,
                                             uint32_t* out, size_t length);

/* x y z x y z ... of the control points, m and m/s; length must be three times the points. */
tremolo_status tremolo_tets_positions(const tremolo_tets_world* world, size_t body, double* out,
                                      size_t length);
tremolo_status tremolo_tets_velocities(const tremolo_tets_world* world, size_t body, double* out,
                                       size_t length);
/* Sets both, and wakes the body and all that sleeps with it. Where positions change, friction
 * forgets its displacement. */
tremolo_status tremolo_tets_set_state(tremolo_tets_world* world, size_t body,
                                      const double* positions, const double* velocities,
                                      size_t length);

/* Grabs a vertex of the drawn surface from the next step on, by a spring, N/m, and a damper, N s/m,
 * to a point, m, which is its position at the step's end and moves with `velocity`, m/s (NULL: 0).
 * Both are implicit: no stiffness is too large. Another call continues the grab; a body has one,
 * which wakes it and all that sleeps with it. TREMOLO_USAGE: the vertex does not exist, or a value
 * is negative or not finite. */
tremolo_status tremolo_tets_pull(tremolo_tets_world* world, size_t body, size_t vertex,
                                 double stiffness, double damping, const double point[3],
                                 const double velocity[3]);
tremolo_status tremolo_tets_let_go(tremolo_tets_world* world, size_t body);
/* Returns a stiffness and a damping that suit the vertex: a supported body moves four fifths of the
 * path of a slow grab, a free one oscillates about it with 2 Hz. TREMOLO_USAGE: the vertex is
 * fixed. */
tremolo_status tremolo_tets_suitable(tremolo_tets_world* world, size_t body, size_t vertex,
                                     double* stiffness, double* damping);

/* asleep: 1 or 0. quadratic_share: of the edges, 0 to 1. Any may be NULL. */
tremolo_status tremolo_tets_look(const tremolo_tets_world* world, size_t body, int32_t* asleep,
                                 double* quadratic_share);

/* Energies of all bodies, J; any may be NULL. contact: stored in contacts. */
tremolo_status tremolo_tets_energy(tremolo_tets_world* world, double* kinetic, double* elastic,
                                   double* gravity, double* contact);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming) */

#endif /* TREMOLO_TETS_H */
