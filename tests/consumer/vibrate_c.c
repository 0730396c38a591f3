/* The C header as a plug-in would use it. */
#include <stdio.h>
#include <stdlib.h>
#include <tremolo/tremolo.h>

int main(int count, char** words) {
  tremolo_model* model = NULL;
  tremolo_body* body = NULL;
  const double force[3] = {0.0, 0.0, 1.0};
  double kinetic = 0.0, potential = 0.0;
  uint32_t* ids = NULL;
  size_t size = 0;
  if (count != 2) return 2;
  if (tremolo_model_load(words[1], 0, &model) != TREMOLO_OK) {
    fprintf(stderr, "%s\n", tremolo_last_error());
    return 1;
  }
  size = tremolo_model_surface_vertices(model);
  ids = malloc(size * sizeof *ids);
  if (ids == NULL || tremolo_model_surface_ids(model, ids, size) != TREMOLO_OK ||
      tremolo_body_create(model, NULL, &body) != TREMOLO_OK ||
      tremolo_body_apply_force(body, ids[size - 1], force, 10) != TREMOLO_OK ||
      tremolo_body_step(body, 100, NULL) != TREMOLO_OK ||
      tremolo_body_energy(body, &kinetic, &potential, NULL) != TREMOLO_OK) {
    fprintf(stderr, "%s\n", tremolo_last_error());
    return 1;
  }
  printf("energy %g J after %g s\n", kinetic + potential, tremolo_body_time(body));
  tremolo_body_destroy(body);
  tremolo_model_release(model);
  free(ids);
  return 0;
}
