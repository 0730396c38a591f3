/* Worlds of bodies of all kinds from C: reduced and rigid bodies, bodies of tetrahedra and cloths,
 * in contact with each other and with colliders under one law (docs/reference.md, "World").
 *
 * As in tremolo.h, whose statuses, models and colliders are used: handles are owned until they are
 * destroyed, NULL may be destroyed, and tremolo_last_error() returns the reason of a failure. Units
 * are SI; vectors are along the world's axes. A world may be used by one thread at a time.
 *
 *   tremolo_scene_create(0.002, &scene);
 *   tremolo_scene_body_init(&place);
 *   place.name = "ball";
 *   place.position[2] = 0.5;
 *   tremolo_collider_sphere(0.1, &sphere);
 *   tremolo_scene_add_rigid(scene, &place, sphere, 1.0);
 *   place.name = "duck";
 *   place.position[2] = 1.0;
 *   tremolo_tets_options_init(&options);
 *   options.file = "duck.tets";
 *   tremolo_scene_add_tets(scene, &place, &options);
 *   tremolo_world_create(scene, 1, &world);
 *   tremolo_world_find(world, "duck", &duck);
 *   for (...) {
 *     tremolo_world_step(world, 1, NULL);
 *     tremolo_world_positions_float(world, duck, positions,
 *                                         3 * tremolo_world_vertices(world, duck));
 *   }
 *
 * A world that is made by these calls has the same bits as one of a scene file with the same
 * values.
 *
 * Bodies, colliders and joints may come and go between steps. A callback that calls its world while
 * that is being stepped gets TREMOLO_USAGE.
 */
#ifndef TREMOLO_SCENE_H
#define TREMOLO_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "tremolo.h"
#include "tremolo_cloth.h"
#include "tremolo_tets.h"

/* NOLINTBEGIN(readability-identifier-naming) */

#ifdef __cplusplus
extern "C" {
#endif

/* The description of a scene. */
typedef struct tremolo_scene tremolo_scene;
/* A simulated scene. */
typedef struct tremolo_world tremolo_world;

/* ---- the scene ---- */

/* A scene without bodies. step: s, of all bodies. Gravity is 9.81 m/s^2 downwards along z. */
tremolo_status tremolo_scene_create(double step, tremolo_scene** scene);

/* Reads a scene file with [[bodies]] (TOML), or the text of one, UTF-8; more can be added. path:
 * where the text would be; paths in it are relative to that. Keys of output are not used. In
 * libtremolo.so. TREMOLO_SYSTEM: the file cannot be read, or the library was built without scene
 * files. TREMOLO_CONTENT: as the program `tremolo run` refuses it, with file, line and key. */
tremolo_status tremolo_scene_read(const char* path, tremolo_scene** scene);
tremolo_status tremolo_scene_parse(const char* text, const char* path, tremolo_scene** scene);

void tremolo_scene_destroy(tremolo_scene* scene);

/* Gravity in m/s^2 and wind in m/s, constant, for all bodies, those that are there and those that
 * follow. TREMOLO_USAGE: a value is not finite. */
tremolo_status tremolo_scene_set_gravity(tremolo_scene* scene, const double gravity[3]);
tremolo_status tremolo_scene_set_wind(tremolo_scene* scene, const double wind[3]);

/* What bodies of all kinds have. Fill with tremolo_scene_body_init. `size` as in
 * tremolo_body_options. */
typedef struct tremolo_scene_body {
  uint32_t size;        /* bytes of this struct as the caller knows it */
  int32_t points;       /* of a reduced or rigid body: at most this many contact points; 200 */
  const char* name;     /* UTF-8, of its own in the scene; required */
  double position[3];   /* m, of the mesh's frame, or of a shape's; 0 */
  double quaternion[4]; /* w, x, y, z, of length one to 1e-6; 1, 0, 0, 0 */
  double velocity[3];   /* m/s, of the centre of mass, or of all particles; 0 */
  double spin[3];       /* rad/s, about it; 0 */
  /* Not of cloth, whose options have them, and the thickness for the margin: */
  double friction;    /* of a pair the geometric mean; 0.3 */
  double restitution; /* 0 to 1, of a pair the geometric mean; 0.5 */
  double margin;      /* distance at which contact begins, over the body's size; 0.005 */
  double stiffness;   /* of contact, as in tremolo_contact_options; 16 */
  double modulus;     /* Pa, instead of the stiffness; 0: the stiffness */
} tremolo_scene_body;

void tremolo_scene_body_init(tremolo_scene_body* place);

/* Add a body of one kind. Values are checked when the world is made; here TREMOLO_USAGE: no name, a
 * position, velocity or spin that is not finite or so large that its square is not, a quaternion of
 * another length; and the errors of the options. A value whose square, or whose energy or momentum
 * with the others, is no finite number is refused in all calls. tremolo_world_add_* do the same
 * while a world runs. */

/* A reduced body. method: integrator, frame and damping; NULL: the defaults, TREMOLO_FIXED. Its
 * step is the scene's. shape: with which points of other bodies collide, in the mesh's frame;
 * copied; NULL: they pass through. velocity and spin are for TREMOLO_FREE; a fixed body with a pose
 * is driven, at rest. */
tremolo_status tremolo_scene_add_reduced(tremolo_scene* scene, const tremolo_scene_body* place,
                                         const tremolo_model* model,
                                         const tremolo_body_options* method,
                                         const tremolo_collider* shape);

/* A rigid body of uniform density. shape: a sphere, capsule, box or cylinder; copied. mass: kg. */
tremolo_status tremolo_scene_add_rigid(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const tremolo_collider* shape, double mass);

/* A body of tetrahedra. Of the options, of which the file is required, position, quaternion,
 * velocity, spin and friction are not read: `place` has them. */
tremolo_status tremolo_scene_add_tets(tremolo_scene* scene, const tremolo_scene_body* place,
                                      const tremolo_tets_options* options);

/* A cloth, which passes through other cloths and itself. method: "implicit-euler", "midpoint" or
 * "energy"; NULL: the first. options: NULL for the defaults. Of `place` name, velocity, stiffness
 * and modulus are read. pins: `count` particles that are fixed at their positions. */
tremolo_status tremolo_scene_add_cloth(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const char* method, const tremolo_cloth_options* options,
                                       const size_t* pins, size_t count);

/* A collider at its pose (next_position and next_quaternion are not read), which
 * tremolo_world_move_collider moves; copied. The n-th one is called "collider n", from 1. */
tremolo_status tremolo_scene_add_collider(tremolo_scene* scene,
                                          const tremolo_placed_collider* collider);

/* A joint between points of two bodies of any kind, or of a body and the world: docs/reference.md,
 * "Joint". Fill with tremolo_joint_init. `size` as in tremolo_body_options. */
typedef struct tremolo_joint {
  uint32_t size;
  int32_t weld;        /* nonzero: all points of `at`, instead of one; 0 */
  const char* body;    /* the name of a body; required */
  const char* at;      /* a vertex's number or a selector, of a cloth a place; required */
  const char* to;      /* the name of the other body; NULL: the world */
  const char* to_at;   /* its vertex; NULL: the place of it at the first one at the start */
  const double* point; /* of the world, m, 3; NULL: where the first vertex is at the start */
  double stiffness;    /* N/m; 0: stiff, with a damper, from masses and step */
  double damping;      /* N s/m; not read of a stiff one */
  double length;       /* m, without force; 0; not of a weld */
  double gap;          /* m, of a weld: the longest offset; 0: the first body's contact margin */
  double until;        /* s; infinity */
  int32_t touch;       /* nonzero: contact between the two continues; 0 */
  int32_t reserved;    /* 0 */
} tremolo_joint;

void tremolo_joint_init(tremolo_joint* joint);

/* TREMOLO_USAGE: no body or place, or a value that is not finite. The rest is checked when the
 * world is made. The n-th joint is number n - 1 of the world. */
tremolo_status tremolo_scene_add_joint(tremolo_scene* scene, const tremolo_joint* joint);

/* ---- the world ---- */

/* A body of a world while it is there; 0 is none. The id of a body that was removed is not used
 * again, and calls with it are TREMOLO_USAGE. */
typedef uint64_t tremolo_body_id;

/* Reads the files that the scene names; the scene is not needed after the call. threads: of a step,
 * the caller's included; 0: one for each core; no bit depends on it. TREMOLO_SYSTEM: a file is
 * missing, or threads cannot be started. TREMOLO_CONTENT: a value is out of range, two bodies have
 * one name, or a body begins inside another or a collider by more than its margin; the message
 * names the body. */
tremolo_status tremolo_world_create(const tremolo_scene* scene, uint32_t threads,
                                    tremolo_world** world);
void tremolo_world_destroy(tremolo_world* world);

/* Advances by `count` steps, or until bodies fail. done (may be NULL) receives the number of steps
 * taken, that in which bodies failed included. TREMOLO_SOLVER or TREMOLO_BOUND: the message names
 * the bodies that failed. They keep their state and are not stepped again; the others have taken
 * their step and continue in the next call. */
tremolo_status tremolo_world_step(tremolo_world* world, int64_t count, int64_t* done);
double tremolo_world_time(const tremolo_world* world);   /* s; 0 for NULL */
int64_t tremolo_world_steps(const tremolo_world* world); /* 0 for NULL */

/* ---- bodies, colliders and joints that come and go ---- */

/* As tremolo_scene_add_*, between two steps; body receives the id. The body's loads begin now.
 * Errors of tremolo_world_create, with the world unchanged. A body that follows poses
 * (TREMOLO_DRIVEN) is moved by tremolo_world_move. */
tremolo_status tremolo_world_add_reduced(tremolo_world* world, const tremolo_scene_body* place,
                                         const tremolo_model* model,
                                         const tremolo_body_options* method,
                                         const tremolo_collider* shape, tremolo_body_id* body);
tremolo_status tremolo_world_add_rigid(tremolo_world* world, const tremolo_scene_body* place,
                                       const tremolo_collider* shape, double mass,
                                       tremolo_body_id* body);
tremolo_status tremolo_world_add_tets(tremolo_world* world, const tremolo_scene_body* place,
                                      const tremolo_tets_options* options, tremolo_body_id* body);
tremolo_status tremolo_world_add_cloth(tremolo_world* world, const tremolo_scene_body* place,
                                       const char* method, const tremolo_cloth_options* options,
                                       const size_t* pins, size_t count, tremolo_body_id* body);

/* Removes a body with its hands and joints. What it touched wakes; its contacts end without an
 * event. Its name may be used again. */
tremolo_status tremolo_world_remove(tremolo_world* world, tremolo_body_id body);

/* The frame of a driven body goes to that pose in the next step and rests there until the next
 * call. Errors as for tremolo_body_move_to. */
tremolo_status tremolo_world_move(tremolo_world* world, tremolo_body_id body,
                                  const double position[3], const double quaternion[4]);

/* Colliders are numbered from 0 in the order in which they were added; numbers are not used again.
 * A collider moves to its new pose within the next step, carries what lies on it, and rests there
 * until the next call; this ends a motion of the scene. tremolo_placed_collider as for
 * tremolo_scene_add_collider. TREMOLO_CONTENT: a body is inside it by more than its margin. */
tremolo_status tremolo_world_add_collider(tremolo_world* world,
                                          const tremolo_placed_collider* collider,
                                          uint32_t* number);
tremolo_status tremolo_world_move_collider(tremolo_world* world, uint32_t collider,
                                           const double position[3], const double quaternion[4]);
tremolo_status tremolo_world_remove_collider(tremolo_world* world, uint32_t collider);
/* By the name in a scene file. TREMOLO_USAGE: there is none. */
tremolo_status tremolo_world_find_collider(const tremolo_world* world, const char* name,
                                           uint32_t* collider);
size_t tremolo_world_colliders(const tremolo_world* world); /* those removed included; 0 for NULL */

/* Joints are numbered from 0, those of the scene first. Errors of tremolo_scene_add_joint;
 * TREMOLO_CONTENT: a place that is not of the body, or ends that are apart. The world is then
 * unchanged. */
tremolo_status tremolo_world_add_joint(tremolo_world* world, const tremolo_joint* joint,
                                       uint32_t* number);
tremolo_status tremolo_world_remove_joint(tremolo_world* world, uint32_t joint);
/* Any may be NULL. force: on the first body in the last step, N, world. energy: stored now, J.
 * holds: 0: it was removed or is over, and the others are 0. */
tremolo_status tremolo_world_joint(const tremolo_world* world, uint32_t joint, double force[3],
                                   double* energy, int32_t* holds);

/* A course in time, of height 1, from `start` on. */
typedef enum tremolo_signal {
  TREMOLO_CONSTANT = 0,
  TREMOLO_PULSE = 1, /* for `duration`; 0: 0.3 s */
  TREMOLO_SINE = 2,  /* sin(2 pi frequency t) for `duration`; 0: without end */
  TREMOLO_RAMP = 3,  /* from 0 to 1 within `duration` (0: 1 s), then 1 */
  TREMOLO_CHIRP = 4, /* from `frequency` to `last_frequency` within `duration`; 0: 1 s */
  TREMOLO_TABLE = 5  /* straight lines between `count` values at times; zero before and after */
} tremolo_signal;

/* A force on vertices of a body of any kind. Fill with tremolo_load_init. `size` as in
 * tremolo_body_options. */
typedef struct tremolo_load {
  uint32_t size;
  int32_t signal; /* a tremolo_signal; TREMOLO_CONSTANT */
  /* A vertex's number or a selector on the boundary, of a cloth also a place as in its pins. NULL:
   * the model's load; tetrahedra and cloths have none. */
  const char* at;
  double force[3];       /* N, world, shared by the vertices; not read of the model's load */
  double scale;          /* times all of it; 1 */
  double start;          /* s, on the body's clock, which began when it was added; 0 */
  double duration;       /* s; 0 */
  double frequency;      /* Hz; 1 */
  double last_frequency; /* Hz; 10 */
  const double* times;   /* of a table: s, ascending, at least two; copied */
  const double* values;
  size_t count;
} tremolo_load;

void tremolo_load_init(tremolo_load* load);

/* TREMOLO_CONTENT: `at` names no vertex, of tetrahedra none on the surface, or only fixed ones.
 * TREMOLO_USAGE: a value that is not finite, or a force so large that numbers overflow. Clocks of
 * bodies that sleep stand still; a load wakes them. */
tremolo_status tremolo_world_add_load(tremolo_world* world, tremolo_body_id body,
                                      const tremolo_load* load);

/* ---- bodies ---- */

typedef enum tremolo_body_kind {
  TREMOLO_REDUCED = 0, /* of a basis file, or on bones */
  TREMOLO_RIGID = 1,
  TREMOLO_TETS = 2,
  TREMOLO_CLOTH = 3
} tremolo_body_kind;

size_t tremolo_world_bodies(const tremolo_world* world); /* that are there; 0 for NULL */
/* The id of the index-th of them, from 0; 0 if there are fewer. Removing a body changes indices. */
tremolo_body_id tremolo_world_body(const tremolo_world* world, size_t index);
/* TREMOLO_USAGE: there is no body of that name. */
tremolo_status tremolo_world_find(const tremolo_world* world, const char* name,
                                  tremolo_body_id* body);
/* UTF-8, the world's; NULL if there is no such body. */
const char* tremolo_world_name(const tremolo_world* world, tremolo_body_id body);
tremolo_status tremolo_world_kind(const tremolo_world* world, tremolo_body_id body,
                                  tremolo_body_kind* kind);

/* A pointer of the caller's that the world keeps for the body; NULL at first, and for a body that
 * is not there. */
tremolo_status tremolo_world_set_user_data(tremolo_world* world, tremolo_body_id body, void* user);
void* tremolo_world_user_data(const tremolo_world* world, tremolo_body_id body);

/* The drawn surface: s vertices and t triangles. 0 for NULL and for a body that does not exist. */
size_t tremolo_world_vertices(const tremolo_world* world, tremolo_body_id body);
size_t tremolo_world_triangles(const tremolo_world* world, tremolo_body_id body);
/* Three vertices per triangle; length must be 3 t. */
tremolo_status tremolo_world_triangle_corners(const tremolo_world* world, tremolo_body_id body,
                                              uint32_t* out, size_t length);

/* Positions of the surface's vertices, x y z x y z ..., m. length must be 3 s. */
tremolo_status tremolo_world_positions_float(const tremolo_world* world, tremolo_body_id body,
                                             float* out, size_t length);
tremolo_status tremolo_world_positions_double(const tremolo_world* world, tremolo_body_id body,
                                              double* out, size_t length);
/* Their velocities, in the same order, m/s. length must be 3 s. TREMOLO_USAGE: a driven body, whose
 * frame has poses instead of a velocity. */
tremolo_status tremolo_world_velocities(const tremolo_world* world, tremolo_body_id body,
                                        double* out, size_t length);
/* Of a reduced body: the weights of the columns of tremolo_model_basis, in the body's frame. length
 * must be tremolo_model_columns. TREMOLO_USAGE: a body of tetrahedra or a cloth. */
tremolo_status tremolo_world_coordinates(const tremolo_world* world, tremolo_body_id body,
                                         double* out, size_t length);

/* The energy balance of a body, J. What a body has now: kinetic, potential (elastic), contact
 * (stored). at_start: their sum at the start. Given since then by each cause, negative where it was
 * taken; 0 where a body of its kind has no such cause:
 *   load      forces on vertices            hand, joint   those that hold the body
 *   support   a moving frame, pins          damping       dampers; not of tetrahedra
 *   gravity, wind                           method        the method itself, and the damping of
 *   contact_given  contact                                tetrahedra; not of reduced bodies
 *   restitution, friction
 * remainder: of the balance, without a known cause; 0 for tetrahedra, whose method has it. */
typedef struct tremolo_energy_account {
  double kinetic, potential, contact, at_start;
  double load, support, gravity, wind, contact_given, restitution, friction, hand, joint, damping,
      method;
  double remainder;
} tremolo_energy_account;

tremolo_status tremolo_world_account(const tremolo_world* world, tremolo_body_id body,
                                     tremolo_energy_account* account);

/* Momentum, kg m/s, and angular momentum about the world's origin, N m s; either may be NULL. */
tremolo_status tremolo_world_momentum(const tremolo_world* world, tremolo_body_id body,
                                      double linear[3], double angular[3]);

/* Contact of a body; any may be NULL. contacts: number of contacts that began. penetration: the
 * largest depth of a contact point at the end of any step, m. force: mean of contact's on the body
 * in the last step, N, world. points: with a force in it. */
tremolo_status tremolo_world_contact(const tremolo_world* world, tremolo_body_id body,
                                     int64_t* contacts, double* penetration, double force[3],
                                     int32_t* points);

/* 1 or 0; either may be NULL. failed: a step of the body failed: it is not stepped again. */
tremolo_status tremolo_world_look(const tremolo_world* world, tremolo_body_id body, int32_t* asleep,
                                  int32_t* failed);

/* Position, m, and quaternion (w, x, y, z) of the frame of a reduced or rigid body; either may be
 * NULL. TREMOLO_USAGE: a body of tetrahedra or a cloth, which has no frame. */
tremolo_status tremolo_world_pose(const tremolo_world* world, tremolo_body_id body,
                                  double position[3], double quaternion[4]);

/* As tremolo_body_apply_force. vertex: of tetrahedra one of the mesh on its surface, of a cloth one
 * of its file or grid; TREMOLO_USAGE: it is fixed. */
tremolo_status tremolo_world_apply_force(tremolo_world* world, tremolo_body_id body,
                                         uint32_t vertex, const double force[3], int32_t steps);

/* ---- sites and hands ---- */

/* A material point of a body's drawn surface: a triangle and weights of its corners, whose sum is
 * 1. */
typedef struct tremolo_site {
  tremolo_body_id body;
  uint32_t triangle;
  uint32_t reserved; /* 0 */
  double weights[3];
} tremolo_site;

/* The first hit of a ray on a drawn surface, from either side. origin: m, world; direction: world,
 * of any length. A miss: site->body is 0. distance (m) and point (m, world) may be NULL.
 * TREMOLO_USAGE: they are not finite, or the direction is zero. */
tremolo_status tremolo_world_pick(const tremolo_world* world, const double origin[3],
                                  const double direction[3], tremolo_site* site, double* distance,
                                  double point[3]);

/* The position, m, and the velocity, m/s, of a site now; either may be NULL. Evaluates the whole
 * surface. TREMOLO_USAGE: there is no such triangle; the velocity of a driven body. */
tremolo_status tremolo_world_site(const tremolo_world* world, const tremolo_site* site,
                                  double position[3], double velocity[3]);

/* Grabs a vertex of a body of any kind by a spring (N/m) and a damper (N s/m) to a point that is at
 * the vertex until it is moved. hand: its number among those of the body. vertex: as in
 * tremolo_body_grab; of tetrahedra a vertex of the mesh on its surface, of a cloth a vertex of its
 * file or grid. A spring stiffer than mass and step allow is replaced, as there. It also holds a
 * body that nothing can touch. Saved states have the hand. TREMOLO_USAGE: a stiffness or damping
 * that is negative or not finite, a particle that a pin holds, a driven body whose method is not
 * avf, ep2 or ep4, a reduced or rigid body without such a vertex. TREMOLO_CONTENT: another body
 * without such a vertex, or with it inside. */
tremolo_status tremolo_world_grab(tremolo_world* world, tremolo_body_id body, uint32_t vertex,
                                  double stiffness, double damping, uint64_t* hand);
/* The same at a site; tetrahedra and cloth are held at the point of contact next to its corner with
 * the largest weight. */
tremolo_status tremolo_world_grab_site(tremolo_world* world, const tremolo_site* site,
                                       double stiffness, double damping, uint64_t* hand);
/* place: of the hand at the end of the next step, m, world. force: on the body in the last step, N,
 * world. TREMOLO_USAGE: the body has no such hand; a place that is not finite. */
tremolo_status tremolo_world_move_hand(tremolo_world* world, tremolo_body_id body, uint64_t hand,
                                       const double place[3]);
tremolo_status tremolo_world_hand_force(const tremolo_world* world, tremolo_body_id body,
                                        uint64_t hand, double force[3]);
tremolo_status tremolo_world_let_go(tremolo_world* world, tremolo_body_id body, uint64_t hand);

/* ---- contacts ---- */

/* A contact of a body with another one or a collider that began or ended. It ends when its points
 * separate for a single step. impulse to normal: since it began. */
typedef struct tremolo_event {
  double time; /* at the end of the step, s */
  tremolo_body_id body;
  tremolo_body_id other; /* 0: a collider */
  uint32_t collider;     /* its number, where other is 0 */
  int32_t begins;        /* 1, or 0: it ended */
  double impulse;        /* sum of |F| h, N s */
  double push[3];        /* sum of F h on `body`, N s, world */
  /* Mean of its points, weighted by their impulses, of the last step with a contact; m, world. */
  double position[3];
  double normal[3]; /* the same mean, out of the other thing, length 1; 0 if they cancel */
} tremolo_event;

/* Events of all steps of the last call of tremolo_world_step, in the order of time; 0 for NULL. */
size_t tremolo_world_events(const tremolo_world* world);
tremolo_status tremolo_world_event(const tremolo_world* world, size_t index, tremolo_event* event);

/* The points of two bodies, or of a body and a collider (other: 0), with a force in the last step:
 * at most `capacity` of them; count receives their number. normal: out of the other thing, impulse:
 * on `body`, also of points of the other one. vertex and on_body as in tremolo_contact_point;
 * obstacle is the other body's id or the collider's number. */
tremolo_status tremolo_world_contact_points(const tremolo_world* world, tremolo_body_id body,
                                            tremolo_body_id other, uint32_t collider,
                                            tremolo_contact_point* out, size_t capacity,
                                            size_t* count);

/* Bodies for which it returns 0 pass through each other. It is called by the thread that steps the
 * world, for pairs of bodies that come near each other. NULL: none do. */
typedef int32_t (*tremolo_filter)(void* user, tremolo_body_id a, tremolo_body_id b);
tremolo_status tremolo_world_set_filter(tremolo_world* world, tremolo_filter filter, void* user);

/* ---- threads ---- */

/* As the number of threads of tremolo_world_create. */
tremolo_status tremolo_world_set_threads(tremolo_world* world, uint32_t threads);

/* The caller's own threads. run must call job(data, index, worker) once for each index below count,
 * on any threads, and return when all are done; worker < workers is another one for each call at a
 * time. No bit depends on it. run: NULL: the world's own threads again. TREMOLO_USAGE: 0 workers,
 * or more than 1024.
 *
 * A call of job with another index or worker, a second one with the same index, and one with a
 * worker that is in use do nothing. Jobs that were not run when run returns, or throws, are run by
 * the thread that steps the world. The step is then complete, and tremolo_world_step ends after it
 * with TREMOLO_USAGE and a message that says what was wrong. */
typedef void (*tremolo_job)(void* data, size_t index, uint32_t worker);
typedef void (*tremolo_run_jobs)(void* user, size_t count, tremolo_job job, void* data);
tremolo_status tremolo_world_set_jobs(tremolo_world* world, uint32_t workers, tremolo_run_jobs run,
                                      void* user);

/* ---- recordings ---- */

/* Records all bodies of a world, of every kind, in the frame that tremolo_recorder_begin_frame has
 * begun; with colliders (nonzero) these too, except such from files. A body that was added or
 * removed since the last frame comes or goes in this one. tremolo_recorder_write then writes what
 * `tremolo export` writes of a scene; point caches (.pc2, .mdd), and .glb for bodies on bones,
 * refuse bodies that come or go. A recorder records one world. TREMOLO_USAGE: it records another
 * one, or no frame has been begun.
 *
 *   tremolo_recorder_create(60.0, &recorder);
 *   for (...) {
 *     tremolo_world_step(world, 5, NULL);
 *     tremolo_recorder_begin_frame(recorder, tremolo_world_time(world));
 *     tremolo_recorder_record_world(recorder, world, 1);
 *   }
 *   tremolo_recorder_write(recorder, "world.usda");
 */
tremolo_status tremolo_recorder_record_world(tremolo_recorder* recorder, const tremolo_world* world,
                                             int32_t colliders);

/* ---- saving ---- */

/* As tremolo_body_save and tremolo_body_restore, of the whole world: the bytes are those of
 * `tremolo run --save`. Bodies, colliders and joints that came, went or were moved by calls must be
 * the same when they are restored. TREMOLO_CONTENT, with the world unchanged: the bytes are
 * damaged, of another version or of another scene, which the message tells. */
tremolo_status tremolo_world_save(const tremolo_world* world, void* bytes, size_t capacity,
                                  size_t* size);
tremolo_status tremolo_world_restore(tremolo_world* world, const void* bytes, size_t size);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming) */

#endif /* TREMOLO_SCENE_H */
