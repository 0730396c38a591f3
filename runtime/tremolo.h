/*
 * libtremolo in C: load a precomputed solid, let it vibrate, read the positions of its surface.
 *
 *   tremolo_model* model;
 *   tremolo_body* body;
 *   double force[3] = {0.0, -40.0, 0.0};
 *   if (tremolo_model_load("horse.tremolo", 0, &model) != TREMOLO_OK) puts(tremolo_last_error());
 *   tremolo_body_create(model, NULL, &body);
 *   tremolo_body_apply_force(body, 17, force, 1);
 *   tremolo_body_step(body, 10, NULL);
 *   tremolo_body_positions_float(body, buffer, buffer_length);
 *   tremolo_body_destroy(body);
 *   tremolo_model_release(model);
 *
 * Status. Every function that can fail returns a tremolo_status; the values are the exit codes of
 * the programs. No C++ exception leaves the library. After a failure tremolo_last_error() returns
 * the reason; outputs are then unchanged unless said otherwise.
 *
 * Ownership. The caller owns every buffer; the library never keeps a pointer to one after the call.
 * A model is owned by the caller until tremolo_model_release; its bodies keep what they need, so it
 * may be released before them. A body is owned until tremolo_body_destroy. Both accept NULL.
 *
 * A crowd is owned until tremolo_crowd_destroy; it keeps what it needs of the models.
 *
 * Threads. A model may be used by any number of threads, a body or a crowd by one at a time. The
 * error message belongs to the calling thread.
 *
 * Linking. `pkg-config --cflags --libs tremolo-c` is libtremolo.so, which exports the functions of
 * this header, tremolo_cloth.h, tremolo_tets.h and tremolo_scene.h, and nothing else; `pkg-config
 * --cflags --libs --static tremolo` the static libraries.
 *
 * Units are SI. A vertex is identified by its index in the precomputed mesh. A null pointer instead
 * of a required object or buffer is TREMOLO_USAGE.
 */
#ifndef TREMOLO_H
#define TREMOLO_H

#include <stddef.h>
#include <stdint.h>

/* NOLINTBEGIN(readability-identifier-naming): types carry the prefix, as C names do */

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header; tremolo_version() is that of the library. */
#define TREMOLO_VERSION_MAJOR 0
#define TREMOLO_VERSION_MINOR 1
#define TREMOLO_VERSION_PATCH 0

typedef enum tremolo_status {
  TREMOLO_OK = 0,
  TREMOLO_SYSTEM = 1,  /* I/O or memory failed */
  TREMOLO_USAGE = 2,   /* an unknown name, a wrong argument, a buffer of the wrong length */
  TREMOLO_CONTENT = 3, /* the file's content is invalid */
  TREMOLO_SOLVER = 4,  /* a step did not converge; the body is as before that step */
  TREMOLO_BOUND = 5    /* a step's energy is far above the energy put in: the method exploded; the
                        * body is in its last valid state (tremolo_body_step) */
} tremolo_status;

typedef struct tremolo_model tremolo_model;
typedef struct tremolo_body tremolo_body;
typedef struct tremolo_crowd tremolo_crowd;

/* The reason of the last failure in this thread: one sentence, UTF-8, never NULL; empty if none
 * failed yet. Valid until the thread's next failing call. */
const char* tremolo_last_error(void);

/* "major.minor.patch"; static. */
const char* tremolo_version(void);

/* Receives messages of the whole library, UTF-8, from the thread that they concern: the reason of
 * each call that fails, and warnings of calls that do not do all that was asked. It must not call
 * the library. If it throws, its message is lost and the call continues. NULL: nobody does, as at
 * first. Set it while no other call is under way. */
typedef enum tremolo_log_level { TREMOLO_LOG_ERROR = 0, TREMOLO_LOG_WARNING = 1 } tremolo_log_level;
typedef void (*tremolo_log)(void* user, tremolo_log_level level, const char* message);
void tremolo_set_log(tremolo_log log, void* user);

/* ---- model ---- */

/* Loads a basis file. modes: leading coordinates to keep (level of detail), 0 for all. */
tremolo_status tremolo_model_load(const char* path, int32_t modes, tremolo_model** model);

/* The same from memory; the bytes are not needed after the call. */
tremolo_status tremolo_model_load_memory(const void* bytes, size_t size, int32_t modes,
                                         tremolo_model** model);

/* The same, but the boundary of the tetrahedra is drawn even if the file has a render surface,
 * which is then not read. */
tremolo_status tremolo_model_load_hull(const char* path, int32_t modes, tremolo_model** model);

void tremolo_model_release(tremolo_model* model);

/* The surface below is the drawn one: the file's render surface, else the boundary of the
 * tetrahedra.
 *
 * Sizes. They are 0 for NULL. */
size_t tremolo_model_modes(const tremolo_model* model);            /* r */
size_t tremolo_model_surface_vertices(const tremolo_model* model); /* s */
size_t tremolo_model_triangles(const tremolo_model* model);        /* t */

/* Natural frequencies, Hz, ascending. length must be r. */
tremolo_status tremolo_model_frequencies(const tremolo_model* model, double* out, size_t length);

/* Corners, three per triangle, counter-clockwise from outside (a render surface: as in its file),
 * as indices 0..s-1 into the surface's vertices (the order of tremolo_body_positions_*). length
 * must be 3 t. */
tremolo_status tremolo_model_triangle_corners(const tremolo_model* model, uint32_t* out,
                                              size_t length);

/* For skinning, on a GPU for example: vertex i is at rest + sum over k of basis[i][k] c[k], in the
 * body's frame, where c are the coordinates of tremolo_body_coordinates. rest: x y z x y z ..., m,
 * length 3 s. basis: for each vertex x, y and z of column 0, then of column 1, and so on; length 3
 * s times the number of columns, which is 0 for NULL. It is r, or more in a model with local
 * responses. */
size_t tremolo_model_columns(const tremolo_model* model);
tremolo_status tremolo_model_rest(const tremolo_model* model, float* out, size_t length);
tremolo_status tremolo_model_basis(const tremolo_model* model, float* out, size_t length);

/* For each of the surface's vertices the vertex of the source mesh for forces: its own id,
 * ascending, on the boundary; on a render surface the one with the largest weight. length must be
 * s. */
tremolo_status tremolo_model_surface_ids(const tremolo_model* model, uint32_t* out, size_t length);

/* Data of a render surface. Its vertices are split where normals or texture coordinates are. The
 * boundary of the tetrahedra has no such data: counts are 0, the arrays are TREMOLO_USAGE. */
int32_t tremolo_model_has_render(const tremolo_model* model);
int32_t tremolo_model_has_uvs(const tremolo_model* model);
int32_t tremolo_model_has_colours(const tremolo_model* model);
size_t tremolo_model_materials(const tremolo_model* model);
size_t tremolo_model_objects(const tremolo_model* model);

/* The name, UTF-8, the model's; NULL if there is no such material or object. */
const char* tremolo_model_material_name(const tremolo_model* model, size_t index);
const char* tremolo_model_object_name(const tremolo_model* model, size_t index);

/* For each triangle its material or object, from 0. length must be t. */
tremolo_status tremolo_model_triangle_materials(const tremolo_model* model, uint32_t* out,
                                                size_t length);
tremolo_status tremolo_model_triangle_objects(const tremolo_model* model, uint32_t* out,
                                              size_t length);

/* Texture coordinates, u v u v ...: length must be 2 s. Colours, red green blue alpha, 0 to 255:
 * length must be 4 s. TREMOLO_USAGE if the surface has none. */
tremolo_status tremolo_model_uvs(const tremolo_model* model, float* out, size_t length);
tremolo_status tremolo_model_colours(const tremolo_model* model, uint8_t* out, size_t length);

/* ---- integrators ---- */

/* The names that tremolo_body_options.integrator may have, static strings; NULL from the first
 * unused index on. docs/choosing-an-integrator.md helps to choose. */
const char* tremolo_integrator_name(size_t index);

/* "ep4", the default, cannot explode, nor can "avf" and "ep2". Methods with an explicit part are
 * conditionally stable: "verlet", "verlet4", "rk2", "rk4", "explicit-euler", "imexv-linear",
 * "imexv", "imexv-thesis" and "imexv-coupled" exceed every bound where the motion stiffens
 * modes that their step does not resolve; runtime/bodies/reduced/integrators/ gives each one's
 * limit. */

/* ---- body ---- */

/* Support of a body. Fixed: it is at rest in the world. Driven: it follows poses that are given
 * step by step. Free: there is none; the body falls, rotates and deforms. Driven bodies need "avf",
 * "ep2", "ep4", "newmark" or "imexv", free ones one of the first three. Both need a basis file with
 * inertia integrals, a free one a basis without fixed vertices (--fix none). */
typedef enum tremolo_frame {
  TREMOLO_FIXED = 0,
  TREMOLO_DRIVEN = 1,
  TREMOLO_FREE = 2
} tremolo_frame;

/* Fill with tremolo_body_options_init, then change fields. `size` lets a program that was
 * compiled against an older header use a newer library: fields beyond it keep their defaults. */
typedef struct tremolo_body_options {
  uint32_t size;          /* bytes of this struct as the caller knows it */
  int32_t max_iterations; /* of a step's solve; 20 */
  const char* integrator; /* a name of tremolo_integrator_name(); "ep4" */
  const char* split;      /* "default", "thesis" or a count such as "9"; "default" */
  double step;            /* h, s; 0.003 */
  double alpha;           /* damping by the mass, 1/s; 0 */
  double beta;            /* damping of the rates of the strains, s; 0 */
  double newmark_beta;    /* 0.25 */
  double newmark_gamma;   /* 0.5 */
  double safety;          /* of the default split, in (0, 1]; 0.9 */
  double tolerance;       /* of a step's solve, relative; 1e-6 */
  int32_t frame;          /* its support, a tremolo_frame; TREMOLO_FIXED */
  int32_t reserved;       /* 0 */
  /* Fractions of critical damping in place of alpha and beta, which must then be 0: "2%" of every
   * mode, "2%,1%" of modes 1, 2 and all further ones, "1:2%,30:5%" Rayleigh damping with these at
   * two frequencies (Hz), or a table of three and more such pairs; NULL: alpha and beta. */
  const char* damping_ratio;
} tremolo_body_options;

void tremolo_body_options_init(tremolo_body_options* options);

/* A body at rest in the rest shape. options: NULL for the defaults. */
tremolo_status tremolo_body_create(const tremolo_model* model, const tremolo_body_options* options,
                                   tremolo_body** body);

void tremolo_body_destroy(tremolo_body* body);

/* A force (x, y, z), N, at a vertex, constant over the next `steps` steps. Several add up. A force
 * that is not finite or so large that numbers overflow is TREMOLO_USAGE. Clearing removes the
 * forces that still act. */
tremolo_status tremolo_body_apply_force(tremolo_body* body, uint32_t vertex, const double force[3],
                                        int32_t steps);
tremolo_status tremolo_body_clear_forces(tremolo_body* body);

/* Advances by `count` steps. done (may be NULL) receives the number of successful steps, also on
 * failure. Forces are then as before the failed step: clear them to continue without.
 * TREMOLO_BOUND: the energy, checked every 8 steps, is more than 100 times the initial energy plus
 * the work of the forces; q and p are those of the last check with at most 10 times that, while the
 * time stays that before the failed step. To go on, set a state or restore a saved body. */
tremolo_status tremolo_body_step(tremolo_body* body, int64_t count, int64_t* done);

double tremolo_body_time(const tremolo_body* body); /* s; 0 for NULL */

/* Reduced coordinates and momenta. length must be r. p may be NULL where they are read. */
tremolo_status tremolo_body_state(const tremolo_body* body, double* q, double* p, size_t length);
tremolo_status tremolo_body_set_state(tremolo_body* body, const double* q, const double* p,
                                      size_t length);

/* Positions of the surface's vertices, x y z x y z ..., m. length must be 3 s. The float variant
 * computes in float: it errs by about 1e-6 of the solid's size. */
tremolo_status tremolo_body_positions_float(const tremolo_body* body, float* out, size_t length);
tremolo_status tremolo_body_positions_double(const tremolo_body* body, double* out, size_t length);

/* Positions as above and the unit normals of the vertices, x y z x y z ..., outwards, weighted by
 * triangle area; vertices of a render surface that are split by texture coordinates only
 * share theirs. length, of both buffers, must be 3 s. */
tremolo_status tremolo_body_surface_float(const tremolo_body* body, float* positions,
                                          float* normals, size_t length);

/* The weights of the columns of tremolo_model_basis; length must be tremolo_model_columns. Of a
 * body on several bones they are only the deformation. */
tremolo_status tremolo_body_coordinates(const tremolo_body* body, double* out, size_t length);

/* The first hit of a ray. */
typedef struct tremolo_hit {
  int32_t found;     /* 0: no hit, the other fields are 0 */
  uint32_t triangle; /* as for tremolo_body_grab_at */
  uint32_t vertex;   /* of the mesh, for forces: at or near the corner with the largest weight */
  uint32_t reserved; /* 0 */
  double weights[3]; /* as for tremolo_body_grab_at */
  double distance;   /* from the ray's origin, m */
  double point[3];   /* m, world */
} tremolo_hit;

/* Finds the first hit of a ray on the deformed surface, from either side. origin: m, world.
 * direction: world, of any length. TREMOLO_USAGE if they are not finite or the direction is zero.
 * A model's first ray builds a search tree for the others. On several bones every triangle is
 * tested, and the hit's vertex may be grabbed, not its point. */
tremolo_status tremolo_body_pick(const tremolo_body* body, const double origin[3],
                                 const double direction[3], tremolo_hit* hit);

/* Saves the complete state between steps. bytes: NULL returns the size alone. capacity: size of the
 * buffer in bytes, TREMOLO_USAGE if it is too small. size receives the number of bytes. */
tremolo_status tremolo_body_save(const tremolo_body* body, void* bytes, size_t capacity,
                                 size_t* size);

/* Restores a saved state: the following steps have the same bits as those of the saved body, under
 * the same forces. TREMOLO_CONTENT, with the body unchanged: the bytes are damaged, of another
 * version, or of a body with another model, method, frame or contact. */
tremolo_status tremolo_body_restore(tremolo_body* body, const void* bytes, size_t size);

/* Sets Rayleigh damping alpha (1/s) and beta (s), or ratios as in tremolo_body_options, from the
 * next step on, in place of all damping before. TREMOLO_USAGE: alpha or beta is negative or not
 * finite, or the text has another form; TREMOLO_CONTENT: a ratio is not in [0, 1), frequencies do
 * not ascend, or there are more ratios than modes. */
tremolo_status tremolo_body_set_damping(tremolo_body* body, double alpha, double beta);
tremolo_status tremolo_body_set_damping_ratio(tremolo_body* body, const char* ratios);

/* J; any of the three may be NULL. high_band: energy of the oscillation of the
 * coordinates above the split (runtime/energy.h). */
tremolo_status tremolo_body_energy(const tremolo_body* body, double* kinetic, double* potential,
                                   double* high_band);

/* ---- bodies whose frame moves ----
 *
 * A body's frame is at a position and a quaternion w, x, y, z of length one: the vertex that is at
 * X in the mesh is at position + rotation (X + u). Positions of surfaces, forces and gravity are
 * along the world's axes. */

/* Moves the body without an impulse: a driven frame is then at rest, a free body keeps its
 * velocities. TREMOLO_USAGE: the body is fixed, a value is not finite, or the quaternion does not
 * have length one to 1e-6. */
tremolo_status tremolo_body_set_pose(tremolo_body* body, const double position[3],
                                     const double quaternion[4]);

/* Either may be NULL. */
tremolo_status tremolo_body_pose(const tremolo_body* body, double position[3],
                                 double quaternion[4]);

/* Motion of a frame in the middle of a step. */
typedef struct tremolo_frame_motion {
  double acceleration[3]; /* of its origin, along the world's axes, m/s^2 */
  double spin[3];         /* along the body's axes, rad/s */
  double spin_rate[3];    /* its rate, along the body's axes, rad/s^2 */
} tremolo_frame_motion;

/* Sets the pose of a driven body's frame at the end of the next step; without a call it is at rest.
 * motion: of that step; NULL: it is extrapolated from the past poses. Errors as
 * tremolo_body_set_pose, and TREMOLO_USAGE if the body is not driven. */
tremolo_status tremolo_body_move_to(tremolo_body* body, const double position[3],
                                    const double quaternion[4], const tremolo_frame_motion* motion);

/* ---- bodies on bones ----
 *
 * A driven body may hang on several bones: x = sum_b w_b(X) T_b (X + u), where T_b is
 * the pose of bone b relative to its pose at rest, a position and a quaternion as above; each bone
 * has a weighted part of the mass. More than one bone needs a basis file with its tetrahedra
 * (tremolo-precompute --keep-elements). Bones are counted from 0. */

/* segments: the two ends of each bone at rest, in the mesh's coordinates, m, six numbers per bone.
 * A point follows the nearest bones, blended over `blend` m (0: a tenth of the body's size).
 * options: frame is not read. TREMOLO_USAGE: a value that is not finite, no bones, a model without
 * inertia integrals or tetrahedra, a method without support for driven bodies. TREMOLO_CONTENT: a
 * model with point masses. */
tremolo_status tremolo_body_create_on_bones(const tremolo_model* model,
                                            const tremolo_body_options* options, size_t bones,
                                            const double* segments, double blend,
                                            tremolo_body** body);

/* weights: one row per drawn vertex, one column per bone, row by row; each row sums to 1 (to 0.001;
 * it is normalized). Errors as above, and TREMOLO_CONTENT for invalid weights. */
tremolo_status tremolo_body_create_with_weights(const tremolo_model* model,
                                                const tremolo_body_options* options, size_t bones,
                                                const double* weights, tremolo_body** body);

/* As tremolo_body_set_pose and tremolo_body_move_to with one bone; those two move all bones.
 * TREMOLO_USAGE also if there is no such bone. */
tremolo_status tremolo_body_set_bone(tremolo_body* body, size_t bone, const double position[3],
                                     const double quaternion[4]);
tremolo_status tremolo_body_move_bone_to(tremolo_body* body, size_t bone, const double position[3],
                                         const double quaternion[4],
                                         const tremolo_frame_motion* motion);

/* Of a free body: the velocity of its centre of mass, m/s, along the world's axes, and its spin,
 * rad/s, along its own. TREMOLO_USAGE if it is not free or a value is not finite. To read, either
 * may be NULL; both are zero for a body that is not free. */
tremolo_status tremolo_body_set_motion(tremolo_body* body, const double velocity[3],
                                       const double spin[3]);
tremolo_status tremolo_body_motion(const tremolo_body* body, double velocity[3], double spin[3]);

/* Of a free body, along the world's axes: linear, kg m/s, and angular about the world's origin,
 * N m s. Either may be NULL; both are zero for a body that is not free. */
tremolo_status tremolo_body_momentum(const tremolo_body* body, double linear[3], double angular[3]);

/* Sets gravity, m/s^2, along the world's axes, from the next step on. TREMOLO_USAGE: it is not
 * finite, or the model has no inertia integrals. */
tremolo_status tremolo_body_set_gravity(tremolo_body* body, const double gravity[3]);

/* Work of each cause on the body since the start, J; any may be NULL. support: of the accelerations
 * of its frame. damping: negative. Kinetic and potential energy change by their sum and the values
 * of tremolo_body_contact_work. */
tremolo_status tremolo_body_work(const tremolo_body* body, double* load, double* support,
                                 double* gravity, double* damping);

/* ---- colliders and grabs ----
 *
 * A collider is a shape in a frame of its own, whose pose is given in each step. Contact between
 * bodies is below. */

/* A shape, owned until tremolo_collider_destroy; made below. */
typedef struct tremolo_collider tremolo_collider;

/* Fill with tremolo_contact_options_init. `size` as in tremolo_body_options. */
typedef struct tremolo_contact_options {
  uint32_t size;                 /* bytes of this struct as the caller knows it */
  int32_t points;                /* at most this many contact points on the boundary; 200 */
  double margin;                 /* distance at which contact begins, over the body's size; 0.005 */
  double stiffness;              /* (3 ms omega)^2 of the whole body a margin deep on its whole
                                  * boundary, whatever the step; 16 */
  const tremolo_collider* shape; /* shape for other bodies, in the mesh's frame; copied; NULL:
                                  * they pass through */
  double friction;               /* with other bodies; 0.3 */
  double restitution;            /* of a point, 0 to 1; 0.5 */
  double modulus; /* Pa, instead of the stiffness: the pressure is modulus x / size at
                   * the depth x; 0: the stiffness */
} tremolo_contact_options;

void tremolo_contact_options_init(tremolo_contact_options* options);

/* Enables contact with colliders, and grabs. options: NULL for the defaults. TREMOLO_USAGE for
 * options out of range, for a driven or free body of another method than "avf", "ep2" and "ep4",
 * and for a model without inertia integrals; TREMOLO_CONTENT for a shape that extends beyond the
 * body by more than its size, and for a plane. */
tremolo_status tremolo_body_set_contact(tremolo_body* body, const tremolo_contact_options* options);

/* Make a shape; destroying accepts NULL. Plane: all of z <= 0. Capsule
 * and cylinder are along z. Sizes are m; TREMOLO_CONTENT for one that is not positive (half_length:
 * negative) or not finite. Load: a file of `tremolo-precompute collider`. */
tremolo_status tremolo_collider_plane(tremolo_collider** collider);
tremolo_status tremolo_collider_sphere(double radius, tremolo_collider** collider);
tremolo_status tremolo_collider_capsule(double radius, double half_length,
                                        tremolo_collider** collider);
tremolo_status tremolo_collider_box(const double half_extents[3], tremolo_collider** collider);
tremolo_status tremolo_collider_cylinder(double radius, double half_length,
                                         tremolo_collider** collider);
tremolo_status tremolo_collider_load(const char* path, tremolo_collider** collider);
void tremolo_collider_destroy(tremolo_collider* collider);

/* The distance from the shape's surface to a point in the shape's frame, m, negative inside. normal
 * (may be NULL): direction of the shortest path out. TREMOLO_USAGE for a point that is not
 * finite. */
tremolo_status tremolo_collider_distance(const tremolo_collider* collider, const double point[3],
                                         double* distance, double normal[3]);

/* A collider in one step: its frame moves from one pose to the next. Quaternions are w, x, y, z, of
 * length one to 1e-6. friction: not negative. restitution: rebound speed over arrival speed, 0 to
 * 1. Fill with tremolo_placed_collider_init: a fixed collider at the origin. */
typedef struct tremolo_placed_collider {
  const tremolo_collider* collider;
  double position[3];        /* m */
  double quaternion[4];      /* at the start of the step */
  double next_position[3];   /* m */
  double next_quaternion[4]; /* at its end */
  double friction;           /* 0.3 */
  double restitution;        /* 0.5 */
} tremolo_placed_collider;

void tremolo_placed_collider_init(tremolo_placed_collider* placed,
                                  const tremolo_collider* collider);

/* One step among `count` colliders. Errors as tremolo_body_step; TREMOLO_USAGE, and no step, for a
 * pose, friction or restitution out of range. A body without tremolo_body_set_contact ignores
 * them. */
tremolo_status tremolo_body_step_among(tremolo_body* body, const tremolo_placed_collider* colliders,
                                       size_t count);

/* Contact in the last step; any may be NULL. penetration: of the deepest point behind a surface, m.
 * impulse: sum of |F| h, N s. points: number of points with a contact force. */
tremolo_status tremolo_body_contact(const tremolo_body* body, double* penetration, double* impulse,
                                    int32_t* points);

/* The impulse of each collider of the last step, N s, 0 without contact. length must be their
 * count. */
tremolo_status tremolo_body_contact_impulses(const tremolo_body* body, double* out, size_t length);

/* The impulse on each collider in the last step as a vector, x y z x y z ..., N s, world; over the
 * step it is the force. length must be 3 times their count. Keep the order of
 * colliders in the array from step to step: friction stores the index of a point's collider. */
tremolo_status tremolo_body_collider_impulses(const tremolo_body* body, double* out, size_t length);

/* A point of the body with a contact force in the last step. */
typedef struct tremolo_contact_point {
  uint32_t vertex;    /* of the body's mesh */
  int32_t on_body;    /* 1: the obstacle is a body, 0: a collider */
  uint64_t obstacle;  /* its number among the colliders, or among the bodies of the contacts */
  double position[3]; /* at the end of the step, m, world */
  double normal[3];   /* out of the obstacle, length 1, world */
  double impulse[3];  /* on the body, N s, world */
} tremolo_contact_point;

/* Writes at most `capacity` of the points with a contact force in the last step; count receives
 * their number. A point of another body on this one's shape is listed by that body. */
tremolo_status tremolo_body_contact_points(const tremolo_body* body, tremolo_contact_point* out,
                                           size_t capacity, size_t* count);

/* J; any may be NULL. stored: between the body and colliders, now. The others are sums since the
 * start: energy given by moving colliders, taken by restitution and friction (negative), given by
 * grabs, and stored energy found at the start of a step but not at the end of the step before
 * (error: it should be zero). With the values of tremolo_body_work they are the change of kinetic,
 * potential and stored energy, less error. */
tremolo_status tremolo_body_contact_work(const tremolo_body* body, double* stored, double* given,
                                         double* restitution, double* friction, double* hand,
                                         double* error);

/* Grabs a vertex at its position by a spring (N/m) and a damper (N s/m) to a point. The point
 * reaches the position given to tremolo_body_move_hand at the end of the next step. Both are
 * implicit. A stiffness above that of tremolo_body_pin is replaced by it, and a damping above h/2
 * times that stiffness by that (h: the step); tremolo_body_hand_spring returns the values in use.
 * hand receives its number. Needs tremolo_body_set_contact; grabs act in steps of tremolo_body_step
 * too. TREMOLO_USAGE: a value is not finite or negative, or the hand does not exist. */
tremolo_status tremolo_body_grab(tremolo_body* body, uint32_t vertex, double stiffness,
                                 double damping, uint64_t* hand);
tremolo_status tremolo_body_move_hand(tremolo_body* body, uint64_t hand, const double place[3]);
tremolo_status tremolo_body_release(tremolo_body* body, uint64_t hand);

/* The same at any point of the drawn surface: in a triangle (tremolo_model_triangle_corners) at the
 * mean of its corners by weights that are not negative and sum to one, as tremolo_body_pick returns
 * them. TREMOLO_USAGE also for an invalid point, and for a body on several bones. */
tremolo_status tremolo_body_grab_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                    double stiffness, double damping, uint64_t* hand);

/* Holds a vertex, or a point, at its position, or where tremolo_body_move_hand moves it, until
 * tremolo_body_release. The stiffness follows from mass and step (Body::pin in runtime/body.h has
 * the formula and the displacement under load). */
tremolo_status tremolo_body_pin(tremolo_body* body, uint32_t vertex, uint64_t* hand);
tremolo_status tremolo_body_pin_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                   uint64_t* hand);

/* Force on the body in the last step, N; the hand feels the opposite. Zero if the hand does not
 * exist. */
tremolo_status tremolo_body_hand_force(const tremolo_body* body, uint64_t hand, double force[3]);
/* The spring (N/m) and the damper (N s/m) in use, either may be NULL. Zero if the hand does not
 * exist. A longer step may lower them again. */
tremolo_status tremolo_body_hand_spring(const tremolo_body* body, uint64_t hand, double* stiffness,
                                        double* damping);

/* ---- contact and joints between bodies ----
 *
 * Bodies with tremolo_body_set_contact that are stepped together. Bodies that may be in contact,
 * and bodies with a joint, are solved for at once; the others step by themselves. A free body that
 * has been nearly at rest for half a second sleeps with all bodies in contact with it: it costs
 * nothing, and wakes when something comes near or begins to act, or where its state is set.
 */
typedef struct tremolo_contacts tremolo_contacts;

/* sleep: nonzero for bodies that fall asleep. Destroying accepts NULL; the bodies stay. */
tremolo_status tremolo_contacts_create(int32_t sleep, tremolo_contacts** contacts);
void tremolo_contacts_destroy(tremolo_contacts* contacts);

/* Sets the number of threads that step the bodies, the caller's included; 0: one for each core.
 * Default: 1. No bit depends on it. TREMOLO_SYSTEM, with nothing changed: they cannot be
 * started. */
tremolo_status tremolo_contacts_set_threads(tremolo_contacts* contacts, uint32_t threads);

/* The body is stepped by tremolo_contacts_step from now on; it must outlive the contacts. number
 * (may be NULL): its own here, from 0; the order decides that of sums. TREMOLO_USAGE without
 * tremolo_body_set_contact, for a step other than the others', or a body that is already added. */
tremolo_status tremolo_contacts_add(tremolo_contacts* contacts, tremolo_body* body,
                                    uint32_t* number);

/* One step of all bodies among `count` colliders. TREMOLO_SOLVER or TREMOLO_BOUND if bodies failed:
 * they are unchanged, the others have taken their step, and the message is that of the first.
 * failed (may be NULL) receives the first `length` of their numbers; failed_count (may be NULL)
 * their count. */
tremolo_status tremolo_contacts_step(tremolo_contacts* contacts,
                                     const tremolo_placed_collider* colliders, size_t count,
                                     uint32_t* failed, size_t length, size_t* failed_count);

/* Pairs of bodies with a contact force in the last step: pairs of numbers and the impulse of each,
 * N s. bodies (2 `length` numbers) and impulses (`length`) receive the first `length`; any may be
 * NULL. count receives the number of pairs. */
tremolo_status tremolo_contacts_touches(const tremolo_contacts* contacts, uint32_t* bodies,
                                        double* impulses, size_t length, size_t* count);

tremolo_status tremolo_contacts_asleep(const tremolo_contacts* contacts, uint32_t body,
                                       int32_t* asleep);
tremolo_status tremolo_contacts_wake(tremolo_contacts* contacts, uint32_t body);

/* A joint: a spring and a damper between vertices of two bodies. Fill with
 * tremolo_joint_options_init. `size` as in tremolo_body_options. */
typedef struct tremolo_joint_options {
  uint32_t size;
  uint32_t vertex;    /* of the first body */
  uint32_t to_vertex; /* of the second */
  int32_t to_place;   /* nonzero: the first vertex's present position on the second; 0 */
  int32_t touch;      /* nonzero: contact between the two continues; 0 */
  int32_t reserved;   /* 0 */
  double stiffness;   /* N/m; 0: stiff, with a damper, from masses and step */
  double damping;     /* N s/m; not read of a stiff one */
  double length;      /* m, without force; 0 */
} tremolo_joint_options;

void tremolo_joint_options_init(tremolo_joint_options* options);

/* joint receives its number. TREMOLO_USAGE: a value is not finite or negative, or neither point can
 * move. */
tremolo_status tremolo_contacts_join(tremolo_contacts* contacts, uint32_t a, uint32_t b,
                                     const tremolo_joint_options* options, uint64_t* joint);
tremolo_status tremolo_contacts_separate(tremolo_contacts* contacts, uint64_t joint);
/* Any may be NULL. force: on the first point in the last step, N. energy: stored now, J. damped:
 * taken since the start, J. */
tremolo_status tremolo_contacts_joint(const tremolo_contacts* contacts, uint64_t joint,
                                      double force[3], double* energy, double* damped);

/* ---- crowd: many bodies ----
 *
 * Bodies in groups that share a model, a method, a step and a level of detail. Bodies of "ep4", the
 * default, "ep2", "avf", "verlet" and "imexv-linear" are stepped 16 (float) or 8 (double) at a
 * time; those of other methods, and all with stiffness damping, one by one. A new body sleeps and
 * costs nothing until a force, a state or tremolo_crowd_wake wakes it; it falls asleep when its
 * energy has been small for some time, and keeps its state. The result does not depend on the
 * number of threads. Details: runtime/crowd.h.
 */

/* Fill with tremolo_group_options_init. `size` as in tremolo_body_options. */
typedef struct tremolo_group_options {
  uint32_t size;             /* bytes of this struct as the caller knows it */
  int32_t modes;             /* leading coordinates that move; 0: all of the model's */
  int32_t single_precision;  /* nonzero: the nonlinear force of the methods that step several at a
                              * time in float; all else is double; 0 */
  int32_t reserved;          /* 0 */
  double sleep_energy;       /* J, below which a body may sleep; 0: by sleep_displacement */
  double sleep_displacement; /* of its size, by its first mode; 1e-4 */
  double sleep_time;         /* s, for which its energy must stay below; infinity: never; 0.5 */
} tremolo_group_options;

void tremolo_group_options_init(tremolo_group_options* options);

/* threads: number of threads in a step, the caller's included; 0: one for each core. */
tremolo_status tremolo_crowd_create(uint32_t threads, tremolo_crowd** crowd);
void tremolo_crowd_destroy(tremolo_crowd* crowd);

/* method: integrator, step and damping; NULL: the defaults of a body, "ep4". options: NULL for the
 * defaults. Fewer modes than the model's are for "verlet" and "imexv-linear"; for others load the
 * model with fewer. */
tremolo_status tremolo_crowd_add_group(tremolo_crowd* crowd, const tremolo_model* model,
                                       const tremolo_body_options* method,
                                       const tremolo_group_options* options, uint32_t* group);

/* A body at rest, asleep. Removing it hides it; its number is not used again. Moving changes
 * its group to another one of the same model, for example another level of detail. */
tremolo_status tremolo_crowd_add_body(tremolo_crowd* crowd, uint32_t group, uint32_t* body);
tremolo_status tremolo_crowd_remove_body(tremolo_crowd* crowd, uint32_t body);
tremolo_status tremolo_crowd_move_body(tremolo_crowd* crowd, uint32_t body, uint32_t group);

/* As tremolo_body_apply_force; wakes the body. Clearing removes those that still act. */
tremolo_status tremolo_crowd_apply_force(tremolo_crowd* crowd, uint32_t body, uint32_t vertex,
                                         const double force[3], int32_t steps);
tremolo_status tremolo_crowd_clear_forces(tremolo_crowd* crowd, uint32_t body);

/* Advances every body that is awake by one step of its group. Allocates nothing. TREMOLO_SOLVER if
 * bodies failed, also by an energy as at TREMOLO_BOUND: each returns to its last valid state,
 * without its forces, and sleeps; the others have taken their step. The message gives the reason of
 * the first failure. failed (may be NULL) receives the first `length` of their numbers;
 * failed_count (may be NULL) their count. */
tremolo_status tremolo_crowd_step(tremolo_crowd* crowd, uint32_t* failed, size_t length,
                                  size_t* failed_count);

size_t tremolo_crowd_awake(const tremolo_crowd* crowd); /* bodies; 0 for NULL */
tremolo_status tremolo_crowd_wake(tremolo_crowd* crowd, uint32_t body);
tremolo_status tremolo_crowd_sleep(tremolo_crowd* crowd, uint32_t body);

/* As tremolo_body_state; length must be the group's number of modes. Setting wakes the body. */
tremolo_status tremolo_crowd_state(const tremolo_crowd* crowd, uint32_t body, double* q, double* p,
                                   size_t length);
tremolo_status tremolo_crowd_set_state(tremolo_crowd* crowd, uint32_t body, const double* q,
                                       const double* p, size_t length);

/* As tremolo_body_energy. */
tremolo_status tremolo_crowd_energy(const tremolo_crowd* crowd, uint32_t body, double* kinetic,
                                    double* potential, double* high_band);

/* Only shown (nonzero) bodies have a surface. Updating rebuilds those that moved; updated (may be
 * NULL) receives their number. */
tremolo_status tremolo_crowd_set_shown(tremolo_crowd* crowd, uint32_t body, int32_t shown);
tremolo_status tremolo_crowd_update_surfaces(tremolo_crowd* crowd, size_t* updated);

/* Positions as of the last update, as tremolo_body_positions_float, in the crowd's own memory:
 * valid until the next call that changes the crowd. version (may be NULL) grows with every rebuild.
 */
tremolo_status tremolo_crowd_surface(const tremolo_crowd* crowd, uint32_t body,
                                     const float** positions, size_t* length, uint64_t* version);

/* ---- periodic motion: response curves and backbones ----
 *
 * tremolo_response follows the periodic motions of a fixed body under a load sin(2 pi f t) over the
 * frequency f, through folds; tremolo_backbone follows the free motions of one mode, without load
 * and damping, over the amplitude. Both solve by harmonic balance, usually within a second, and
 * give a curve: points, and bifurcations with folds among them. tremolo_damped_backbone,
 * tremolo_fold_curve and tremolo_branch_curve give further curves. docs/response.md explains the
 * terms.
 *
 *   tremolo_curve_options_init(&options);
 *   options.damping_ratio = "2%";
 *   tremolo_response(model, &options, 0.8, 1.3, &curve);
 *   for (i = 0; i < tremolo_curve_points(curve); ++i) tremolo_curve_point_at(curve, i, &point);
 *   tremolo_curve_destroy(curve);
 */
typedef struct tremolo_curve tremolo_curve;

/* Instead of a vertex: the one that moves most in the mode. */
#define TREMOLO_ANY_VERTEX UINT32_MAX

/* One harmonic of a load in time: scale sin(number 2 pi f t + degrees). */
typedef struct tremolo_load_harmonic {
  int32_t number;   /* 1 to 99, not above most_harmonics */
  int32_t reserved; /* 0 */
  double scale;
  double degrees;
} tremolo_load_harmonic;

/* Fill with tremolo_curve_options_init. `size` as in tremolo_body_options. */
typedef struct tremolo_curve_options {
  uint32_t size;            /* bytes of this struct as the caller knows it */
  uint32_t probe;           /* the vertex whose largest displacement is the amplitude;
                             * TREMOLO_ANY_VERTEX */
  int32_t mode;             /* whose backbone it is, and in which a chosen probe moves; from 1; 1 */
  int32_t harmonics;        /* of the motion at the start, 1 to 99; 5 */
  int32_t most_harmonics;   /* more are added up to this number, to 99; 0: 25 of a response, 15 of
                             * a backbone, or `harmonics` if that is more; 0 */
  int32_t most_points;      /* a curve ends after so many, from 2 on; 4000 */
  int32_t stability;        /* nonzero: stability and bifurcations are computed; 1 */
  int32_t reserved;         /* 0 */
  double harmonic_share;    /* harmonics are added where the two highest hold more; 0.001 */
  double longest_step;      /* between two points, relative to the motion, in (0, 1]; 0.1 */
  double largest_amplitude; /* m, a curve ends there as unbounded; 0: the body's size */
  double gravity[3];        /* a constant acceleration, m/s^2; 0 */
  /* Of responses and damped backbones: the load is load_scale times the forces (x, y, z of each
   * vertex, N) on load_count vertices, or times the model's default load if load_vertices is NULL.
   */
  double load_scale;   /* not 0; 1 */
  double static_scale; /* the same forces also act constantly, times this; 0 */
  const uint32_t* load_vertices;
  const double* load_forces; /* 3 load_count */
  size_t load_count;
  double alpha;              /* damping as in tremolo_body_options; 0 */
  double beta;               /* 0 */
  const char* damping_ratio; /* as "2%", by mode "2%,1%", or a table in Hz "1:2%,10:1%,30:5%"; NULL:
                              * alpha and beta */
  /* Of responses alone: the sum of load_harmonic_count harmonics is the load's course in time;
   * NULL: sin(2 pi f t). */
  const tremolo_load_harmonic* load_harmonics;
  size_t load_harmonic_count;
} tremolo_curve_options;

void tremolo_curve_options_init(tremolo_curve_options* options);

/* The end of a curve: at the requested frequency or amplitude; at the largest amplitude; back in
 * the range where it had begun; where no further point was found; after most_points points; a
 * backbone on that of a mode of twice the frequency; back on one of its own points; a backbone
 * where the two highest harmonics hold more than 50 harmonic_share. */
typedef enum tremolo_curve_end {
  TREMOLO_CURVE_DONE = 0,
  TREMOLO_CURVE_UNBOUNDED = 1,
  TREMOLO_CURVE_RETURNED = 2,
  TREMOLO_CURVE_STUCK = 3,
  TREMOLO_CURVE_LONG = 4,
  TREMOLO_CURVE_JOINED = 6,
  TREMOLO_CURVE_LOOP = 7,
  TREMOLO_CURVE_COARSE = 8
} tremolo_curve_end;

/* One periodic motion. */
typedef struct tremolo_curve_point {
  double frequency_hz;
  double amplitude;  /* largest distance of the probe from its place at rest over a period, m */
  double energy;     /* mean over the period, J; of a free motion constant */
  double last_share; /* of the two highest harmonics in the motion, 0 to 1 */
  double load_scale; /* of the load in this motion: changes along damped backbones and fold curves,
                      * else that of the options; 0 of a free backbone */
  int32_t stable;    /* 1: stable, 0: unstable, -1: not computed */
  int32_t harmonics; /* H */
} tremolo_curve_point;

/* A point where the curve turns over the frequency, another curve crosses, the period doubles, or
 * the motion becomes a quasi-periodic one. */
typedef enum tremolo_bifurcation_kind {
  TREMOLO_FOLD = 0,
  TREMOLO_BRANCH = 1,
  TREMOLO_PERIOD_DOUBLING = 2,
  TREMOLO_NEIMARK_SACKER = 3
} tremolo_bifurcation_kind;

typedef struct tremolo_bifurcation {
  int32_t kind;         /* a tremolo_bifurcation_kind */
  int32_t reserved;     /* 0 */
  double multiplier[2]; /* real and imaginary part of the one that crosses the unit circle */
  tremolo_curve_point point;
} tremolo_bifurcation;

/* From from_hz to to_hz, which may be lower. options: NULL for the defaults. A curve that ends
 * early is TREMOLO_OK and keeps its points: tremolo_curve_reached. Without damping no stability is
 * computed, no harmonics are added, and there are at most 500 points. TREMOLO_USAGE: alpha or beta
 * with damping_ratio, or a vertex that does not exist. TREMOLO_CONTENT: frequencies that are not
 * positive or equal, other options out of range, a model without a default load if load_vertices is
 * NULL, a load or a probe that does not move, or constant forces beyond buckling. TREMOLO_SOLVER:
 * no motion was found at from_hz. */
tremolo_status tremolo_response(const tremolo_model* model, const tremolo_curve_options* options,
                                double from_hz, double to_hz, tremolo_curve** curve);

/* To an amplitude, m. options: NULL for mode 1. TREMOLO_CONTENT: the amplitude is not positive, the
 * mode does not exist, or the options have a damping. */
tremolo_status tremolo_backbone(const tremolo_model* model, const tremolo_curve_options* options,
                                double to_amplitude, tremolo_curve** curve);

/* Phase resonance, to an amplitude, m: the damped motions under a load load_scale cos(2 pi f t)
 * whose displacement along the load lags it by 90 degrees. load_scale of each point is the load
 * that keeps it. These are the ridge of the response curves. Errors as for both curves above; also
 * TREMOLO_USAGE: the options have load_harmonics; TREMOLO_CONTENT: no damping, or the load does not
 * move the mode. */
tremolo_status tremolo_damped_backbone(const tremolo_model* model,
                                       const tremolo_curve_options* options, double to_amplitude,
                                       tremolo_curve** curve);

/* Follows a fold of a response (a number of tremolo_curve_bifurcation_at) over the load, to
 * to_load_scale, or through a cusp, where two folds meet, back to the response's load_scale. The
 * cusps are the new curve's bifurcations. Its points have no stability. The response may be
 * destroyed first. TREMOLO_USAGE: the curve is not one of tremolo_response, or there is no such
 * fold. TREMOLO_CONTENT: to_load_scale is 0 or of the other sign. TREMOLO_SOLVER: nothing was found
 * there. */
tremolo_status tremolo_fold_curve(const tremolo_curve* response, size_t bifurcation,
                                  double to_load_scale, tremolo_curve** curve);

/* Follows the branch that crosses a response at a branch point, in the direction 1 or -1, until it
 * meets the response again or leaves its range. Errors as for tremolo_fold_curve; TREMOLO_USAGE:
 * another direction. */
tremolo_status tremolo_branch_curve(const tremolo_curve* response, size_t bifurcation,
                                    int32_t direction, tremolo_curve** curve);

void tremolo_curve_destroy(tremolo_curve* curve);

size_t tremolo_curve_points(const tremolo_curve* curve);       /* 0 for NULL */
size_t tremolo_curve_bifurcations(const tremolo_curve* curve); /* folds included; 0 for NULL */
uint32_t tremolo_curve_probe(const tremolo_curve* curve);      /* TREMOLO_ANY_VERTEX for NULL */

/* A tremolo_curve_end, and the reason in one sentence: empty where the end is as requested. The
 * text is the curve's. */
tremolo_curve_end tremolo_curve_reached(const tremolo_curve* curve);
const char* tremolo_curve_reason(const tremolo_curve* curve);

/* In the order of the curve. TREMOLO_USAGE if there is no such point or bifurcation. */
tremolo_status tremolo_curve_point_at(const tremolo_curve* curve, size_t index,
                                      tremolo_curve_point* point);
tremolo_status tremolo_curve_bifurcation_at(const tremolo_curve* curve, size_t index,
                                            tremolo_bifurcation* bifurcation);

/* The motion of a point in the reduced coordinates, q(t) = c_0 + sum a_k cos 2 pi k f t + b_k sin
 * 2 pi k f t: r numbers each of c_0, a_1, b_1, a_2, ..., b_H. length must be r (2 H + 1). */
tremolo_status tremolo_curve_motion(const tremolo_curve* curve, size_t index, double* out,
                                    size_t length);

/* The state of a point's motion at a fraction of its period, for tremolo_body_set_state. length
 * must be r; p may be NULL. */
tremolo_status tremolo_curve_state(const tremolo_curve* curve, size_t index, double fraction,
                                   double* q, double* p, size_t length);

/* ---- recordings: motion in files for other programs ----
 *
 * Add tracks, then record them frame by frame; write as often as you like. Recording allocates: do
 * it at the rate of pictures, not of steps.
 *
 *   tremolo_recorder_create(60.0, &recorder);
 *   tremolo_recorder_add_body(recorder, body, "horse", &track);
 *   for (...) {
 *     tremolo_body_step(body, 5, NULL);
 *     tremolo_recorder_begin_frame(recorder, tremolo_body_time(body));
 *     tremolo_recorder_record_body(recorder, track, body);
 *   }
 *   tremolo_recorder_write(recorder, "horse.glb");
 *   tremolo_recorder_destroy(recorder);
 */
typedef struct tremolo_recorder tremolo_recorder;

/* rate: intended frames per second, for formats without times. Destroying accepts NULL. */
tremolo_status tremolo_recorder_create(double rate, tremolo_recorder** recorder);
void tremolo_recorder_destroy(tremolo_recorder* recorder);

/* A track is the motion of one body (also on bones), or of a model whose states the caller has,
 * such as those of a crowd. name: UTF-8, unique. track receives its number. A body whose track is
 * added after the first frame is there from the first frame on in which it is recorded.
 * TREMOLO_USAGE: the name is empty or in use. */
tremolo_status tremolo_recorder_add_body(tremolo_recorder* recorder, const tremolo_body* body,
                                         const char* name, size_t* track);
tremolo_status tremolo_recorder_add_model(tremolo_recorder* recorder, const tremolo_model* model,
                                          const char* name, size_t* track);

/* time: s, later than the last frame's. Then every track is recorded once. TREMOLO_USAGE if the
 * time is not later, or a track is missing in the last frame. */
tremolo_status tremolo_recorder_begin_frame(tremolo_recorder* recorder, double time);

/* The body is gone: from the present frame on, or from the next one if this one has it. */
tremolo_status tremolo_recorder_end_track(tremolo_recorder* recorder, size_t track);

/* Records the body's present state. TREMOLO_USAGE, with nothing recorded: the track does not exist,
 * has been recorded in this frame, or is of a model with another number of coordinates. */
tremolo_status tremolo_recorder_record_body(tremolo_recorder* recorder, size_t track,
                                            const tremolo_body* body);

/* The same by the reduced coordinates, of which there may be fewer than the model has: the others
 * are zero. position, quaternion (w, x, y, z): NULL for a frame at the mesh's position. */
tremolo_status tremolo_recorder_record_state(tremolo_recorder* recorder, size_t track,
                                             const double* q, size_t length,
                                             const double position[3], const double quaternion[4]);

/* Writes all frames; the path's ending chooses: .glb (glTF: modes as morph targets), .usda, .pvd
 * (for ParaView, its .vtu files in a folder next to it), .pc2 or .mdd (point caches, the rest
 * shapes as .obj next to them), .ply or .obj (one numbered file per frame), .html (a page that
 * plays it). TREMOLO_USAGE for another ending or while a track is missing in the last frame;
 * TREMOLO_CONTENT for data that the format does not support; TREMOLO_SYSTEM if it cannot be
 * written. */
tremolo_status tremolo_recorder_write(tremolo_recorder* recorder, const char* path);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming) */

#endif /* TREMOLO_H */
