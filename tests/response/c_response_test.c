/* Periodic motion from C. Called from c_response_test.cpp; each function returns 0, or the line
 * that went wrong. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/tremolo.h"
#include "tests/runtime/c_require.h"

int tremolo_c_backbone_round(const tremolo_model* model, double omega, double gamma);
int tremolo_c_response_refusals(const tremolo_model* model);
int tremolo_c_load_refusals(const tremolo_model* model);

/* The angular frequency of x'' + omega^2 x + gamma x^3 = 0 at an amplitude: with m = gamma A^2 / (2
 * s^2) and s^2 = omega^2 + gamma A^2 it is pi s / (2 K(m)), K by the arithmetic-geometric mean. */
static double duffing_frequency(double omega, double gamma, double amplitude) {
  const double stiff = omega * omega + gamma * amplitude * amplitude;
  double a = 1.0;
  double b = sqrt(1.0 - gamma * amplitude * amplitude / (2.0 * stiff));
  int i = 0;
  for (i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  return sqrt(stiff) * a;
}

int tremolo_c_backbone_round(const tremolo_model* model, double omega, double gamma) {
  int line = 0;
  const double turn = 6.283185307179586;
  tremolo_curve_options options;
  tremolo_curve* curve = NULL;
  tremolo_curve_point point;
  double* motion = NULL;
  double ratio = 0.0;
  size_t i = 0;
  tremolo_curve_options_init(&options);
  options.harmonics = options.most_harmonics = 25;
  REQUIRE(tremolo_backbone(model, &options, 0.5, &curve) == TREMOLO_OK);
  REQUIRE(tremolo_curve_reached(curve) == TREMOLO_CURVE_DONE);
  REQUIRE(tremolo_curve_reason(curve)[0] == '\0');
  REQUIRE(tremolo_curve_points(curve) > 10 && tremolo_curve_bifurcations(curve) == 0);
  for (i = 0; i < tremolo_curve_points(curve); ++i) {
    double q = 0.0, p = 1.0, exact = 0.0, energy = 0.0;
    int32_t k = 0;
    REQUIRE(tremolo_curve_point_at(curve, i, &point) == TREMOLO_OK);
    /* The phase is such that the coordinate is at its largest at the start of the period. */
    REQUIRE(tremolo_curve_state(curve, i, 0.0, &q, &p, 1) == TREMOLO_OK);
    REQUIRE(fabs(p) <= 1e-7 * omega * fabs(q));
    exact = duffing_frequency(omega, gamma, q) / turn;
    energy = 0.5 * omega * omega * q * q + 0.25 * gamma * q * q * q * q;
    /* 25 harmonics of a motion whose part beyond them is below 1e-9. */
    REQUIRE(fabs(point.frequency_hz - exact) <= 1e-8 * exact);
    REQUIRE(fabs(point.energy - energy) <= 1e-8 * energy);
    REQUIRE(point.harmonics == 25 && point.last_share < 1e-6);
    if (i == 0) ratio = point.amplitude / fabs(q);
    REQUIRE(fabs(point.amplitude / fabs(q) - ratio) <= 1e-9 * ratio);
    /* The sum of the cosines is q(0). */
    motion = malloc(51 * sizeof(*motion));
    REQUIRE(motion);
    REQUIRE(tremolo_curve_motion(curve, i, motion, 51) == TREMOLO_OK);
    for (k = 1; k <= 25; ++k) motion[0] += motion[2 * k - 1];
    REQUIRE(fabs(motion[0] - q) <= 1e-12 * fabs(q));
    free(motion);
    motion = NULL;
  }
  REQUIRE(fabs(point.amplitude - 0.5) <= 1e-9);

done:
  free(motion);
  tremolo_curve_destroy(curve);
  return line;
}

static int refused(tremolo_status status, tremolo_status expected, const char* word) {
  return status == expected && strstr(tremolo_last_error(), word) != NULL;
}

int tremolo_c_response_refusals(const tremolo_model* model) {
  int line = 0;
  tremolo_curve_options options;
  tremolo_curve* curve = NULL;
  tremolo_curve_point point;
  tremolo_bifurcation bifurcation;
  double number = 0.0;
  tremolo_curve_options_init(&options);
  options.damping_ratio = "2%";
  REQUIRE(refused(tremolo_response(NULL, &options, 0.5, 1.0, &curve), TREMOLO_USAGE, "model"));
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, NULL), TREMOLO_USAGE, "curve"));
  REQUIRE(
      refused(tremolo_response(model, &options, 0.0, 1.0, &curve), TREMOLO_CONTENT, "positive"));
  REQUIRE(refused(tremolo_response(model, &options, NAN, 1.0, &curve), TREMOLO_CONTENT, "finite"));
  REQUIRE(refused(tremolo_response(model, &options, 1.0, 1.0, &curve), TREMOLO_CONTENT, "same"));
  options.alpha = 0.1;
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_USAGE, "alpha"));
  options.alpha = 0.0;
  options.damping_ratio = "200%";
  REQUIRE(tremolo_response(model, &options, 0.5, 1.0, &curve) == TREMOLO_CONTENT);
  options.damping_ratio = "much";
  REQUIRE(tremolo_response(model, &options, 0.5, 1.0, &curve) == TREMOLO_USAGE);
  options.damping_ratio = NULL;
  options.beta = -1.0;
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "beta"));
  options.beta = 0.0;
  options.harmonics = 0;
  REQUIRE(
      refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "harmonics"));
  options.harmonics = 5;
  options.most_harmonics = 4;
  REQUIRE(
      refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "harmonics"));
  options.most_harmonics = 15;
  options.load_scale = 0.0;
  REQUIRE(
      refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "load_scale"));
  options.load_scale = 1.0;
  options.probe = 12345678;
  REQUIRE(tremolo_response(model, &options, 0.5, 1.0, &curve) == TREMOLO_USAGE);
  options.probe = TREMOLO_ANY_VERTEX;
  options.load_vertices = &options.probe;
  REQUIRE(
      refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_USAGE, "load_forces"));
  options.load_vertices = NULL;
  options.mode = 99;
  REQUIRE(refused(tremolo_backbone(model, &options, 0.1, &curve), TREMOLO_CONTENT, "mode"));
  options.mode = 1;
  REQUIRE(refused(tremolo_backbone(model, &options, -0.1, &curve), TREMOLO_CONTENT, "amplitude"));
  options.damping_ratio = "2%";
  REQUIRE(refused(tremolo_backbone(model, &options, 0.1, &curve), TREMOLO_CONTENT, "damping"));
  options.size = 0;
  REQUIRE(refused(tremolo_backbone(model, &options, 0.1, &curve), TREMOLO_USAGE, "_init"));
  /* An older program knows the first fields alone: the others keep their defaults. */
  tremolo_curve_options_init(&options);
  options.harmonics = options.most_harmonics = 3;
  options.damping_ratio = "200%";
  options.size = offsetof(tremolo_curve_options, most_points);
  REQUIRE(curve == NULL);
  REQUIRE(tremolo_backbone(model, &options, 0.1, &curve) == TREMOLO_OK);
  REQUIRE(tremolo_curve_point_at(curve, 0, &point) == TREMOLO_OK && point.harmonics == 3);
  REQUIRE(point.load_scale == 0.0);
  REQUIRE(refused(tremolo_fold_curve(curve, 0, 2.0, &curve), TREMOLO_USAGE, "tremolo_response"));
  REQUIRE(refused(tremolo_branch_curve(curve, 0, 1, &curve), TREMOLO_USAGE, "tremolo_response"));
  REQUIRE(refused(tremolo_curve_point_at(curve, tremolo_curve_points(curve), &point), TREMOLO_USAGE,
                  "no point"));
  REQUIRE(refused(tremolo_curve_bifurcation_at(curve, 0, &bifurcation), TREMOLO_USAGE,
                  "no bifurcation"));
  REQUIRE(tremolo_curve_point_at(NULL, 0, &point) == TREMOLO_USAGE);
  REQUIRE(tremolo_curve_point_at(curve, 0, NULL) == TREMOLO_USAGE);
  REQUIRE(refused(tremolo_curve_motion(curve, 0, &number, 1), TREMOLO_USAGE, "length"));
  REQUIRE(refused(tremolo_curve_state(curve, 0, 0.0, &number, NULL, 7), TREMOLO_USAGE, "length"));
  REQUIRE(refused(tremolo_curve_state(curve, 0, NAN, &number, NULL, 1), TREMOLO_USAGE, "finite"));
  REQUIRE(tremolo_curve_points(NULL) == 0 && tremolo_curve_bifurcations(NULL) == 0);
  tremolo_curve_destroy(NULL);

done:
  tremolo_curve_destroy(curve);
  return line;
}

int tremolo_c_load_refusals(const tremolo_model* model) {
  int line = 0;
  tremolo_load_harmonic harmonic = {0, 0, 0.0, 0.0};
  tremolo_curve_options options;
  tremolo_curve* curve = NULL;
  tremolo_curve_options_init(&options);
  REQUIRE(refused(tremolo_damped_backbone(model, &options, 0.1, &curve), TREMOLO_CONTENT,
                  "damping_ratio"));
  options.damping_ratio = "2%";
  REQUIRE(
      refused(tremolo_damped_backbone(model, &options, NAN, &curve), TREMOLO_CONTENT, "amplitude"));
  options.load_harmonics = &harmonic;
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_USAGE,
                  "load_harmonic_count"));
  options.load_harmonic_count = 1;
  REQUIRE(refused(tremolo_damped_backbone(model, &options, 0.1, &curve), TREMOLO_USAGE,
                  "load_harmonics"));
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "1 to 99"));
  harmonic.number = 1;
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "no load"));
  harmonic.scale = NAN;
  REQUIRE(refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "finite"));
  harmonic.number = 26;
  harmonic.scale = 1.0;
  REQUIRE(
      refused(tremolo_response(model, &options, 0.5, 1.0, &curve), TREMOLO_CONTENT, "harmonic 26"));
  REQUIRE(refused(tremolo_fold_curve(NULL, 0, 2.0, &curve), TREMOLO_USAGE, "response"));

done:
  tremolo_curve_destroy(curve);
  return line;
}
