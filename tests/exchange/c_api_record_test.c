/* Recordings from C. Called from c_api_record_test.cpp; returns 0, or the line that went wrong. */
#include <stdlib.h>

#include "runtime/tremolo.h"
#include "tests/runtime/c_require.h"

int tremolo_c_recording(const char* model_path, const char* glb, const char* mdd, const char* bad);

int tremolo_c_recording(const char* model_path, const char* glb, const char* mdd, const char* bad) {
  int line = 0, frame = 0;
  tremolo_model* model = NULL;
  tremolo_body* body = NULL;
  tremolo_recorder* recorder = NULL;
  size_t of_body = 9, of_state = 9;
  double* q = NULL;
  const double position[3] = {0.0, 0.0, 2.0}, quaternion[4] = {1.0, 0.0, 0.0, 0.0};

  REQUIRE(tremolo_recorder_create(50.0, NULL) == TREMOLO_USAGE);
  REQUIRE(tremolo_recorder_begin_frame(NULL, 0.0) == TREMOLO_USAGE);
  REQUIRE(tremolo_model_load(model_path, 0, &model) == TREMOLO_OK);
  REQUIRE(tremolo_body_create(model, NULL, &body) == TREMOLO_OK);
  REQUIRE(tremolo_recorder_create(50.0, &recorder) == TREMOLO_OK);
  REQUIRE(tremolo_recorder_write(recorder, glb) == TREMOLO_USAGE); /* nothing to write */
  REQUIRE(tremolo_recorder_add_body(recorder, body, "body", &of_body) == TREMOLO_OK);
  REQUIRE(tremolo_recorder_add_model(recorder, model, "body", &of_state) == TREMOLO_USAGE);
  REQUIRE(tremolo_recorder_add_model(recorder, model, "state", &of_state) == TREMOLO_OK);
  REQUIRE(of_body == 0 && of_state == 1);
  q = calloc(tremolo_model_modes(model), sizeof(*q));
  REQUIRE(q != NULL);
  q[0] = 0.01;
  REQUIRE(tremolo_body_set_state(body, q, q, tremolo_model_modes(model)) == TREMOLO_OK);
  for (frame = 0; frame < 5; ++frame) {
    REQUIRE(tremolo_recorder_begin_frame(recorder, tremolo_body_time(body)) == TREMOLO_OK);
    REQUIRE(tremolo_recorder_record_body(recorder, of_body, body) == TREMOLO_OK);
    REQUIRE(tremolo_recorder_write(recorder, glb) == TREMOLO_USAGE); /* a track is missing */
    /* One coordinate of several: the others are zero. */
    q[0] = 0.001 * frame;
    REQUIRE(tremolo_recorder_record_state(recorder, of_state, q, 1, position, quaternion) ==
            TREMOLO_OK);
    REQUIRE(tremolo_recorder_record_state(recorder, of_state, q, 1, NULL, NULL) == TREMOLO_USAGE);
    REQUIRE(tremolo_body_step(body, 5, NULL) == TREMOLO_OK);
  }
  REQUIRE(tremolo_recorder_write(recorder, glb) == TREMOLO_OK);
  REQUIRE(tremolo_recorder_write(recorder, mdd) == TREMOLO_OK);
  REQUIRE(tremolo_recorder_write(recorder, bad) == TREMOLO_USAGE);
done:
  tremolo_recorder_destroy(recorder);
  tremolo_recorder_destroy(NULL);
  tremolo_body_destroy(body);
  tremolo_model_release(model);
  free(q);
  return line;
}
