#include "precompute/reference/reference_options.h"

#include <iostream>

#include "formats/file/command_words.h"
#include "precompute/options/solid_options.h"
#include "precompute/system/failure.h"
#include "precompute/system/option_checks.h"

namespace tremolo {
namespace {

void add_time_options(CLI::App& app, ReferenceOptions& options, std::string& scheme) {
  app.add_option("--integrator", scheme, "midpoint, or avf, which keeps the energy")
      ->check(CLI::IsMember({"midpoint", "avf"}))
      ->capture_default_str();
  app.add_option("--step", options.time.step, "s")->capture_default_str();
  app.add_option("--duration", options.duration, "s")->capture_default_str();
  app.add_option("--load", options.load,
                 "of the default load in time: impulse (3 ms), square (0.3 s), sine (1 Hz), "
                 "constant, none (default: impulse)");
  app.add_option("--alpha", options.time.alpha, "damping by the mass, 1/s")->capture_default_str();
  app.add_option("--beta", options.time.beta, "damping of the strain rates, s")
      ->capture_default_str();
}

struct MotionTexts {
  std::string gravity, spin, velocity;
};

void add_world_options(CLI::App& app, ReferenceOptions& options, MotionTexts& texts) {
  app.add_option("--gravity", texts.gravity, "X,Y,Z, m/s^2: acts on all mass from t = 0 on");
  app.add_option("--support-motion", options.support_motion,
                 "CSV file, a line a moment: t, x, y, z, qw, qx, qy, qz (s, m): what is fixed "
                 "follows these poses, with a cubic spline between them");
  app.add_option("--spin", texts.spin,
                 "X,Y,Z, rad/s about the centre of mass: a free body (--fix none) flies, beginning "
                 "with this");
  app.add_option("--velocity", texts.velocity,
                 "X,Y,Z, m/s of the centre of mass: a free body (--fix none) begins with this");
}

// Returns false if a text is no vector; the error has been printed.
bool finish_vector(const std::string& text, const char* flag, const char* unit,
                   std::optional<Eigen::Vector3d>& vector) {
  if (text.empty()) return true;
  vector.emplace();
  if (parse_vector(text, *vector)) return true;
  std::cerr << "tremolo-precompute: " << flag << " " << text
            << ": expected three numbers, X,Y,Z in " << unit << "\n";
  return false;
}

bool finish_motion_texts(const MotionTexts& texts, ReferenceOptions& options) {
  std::optional<Eigen::Vector3d> gravity;
  if (!finish_vector(texts.gravity, "--gravity", "m/s^2", gravity) ||
      !finish_vector(texts.spin, "--spin", "rad/s", options.spin) ||
      !finish_vector(texts.velocity, "--velocity", "m/s", options.velocity))
    return false;
  options.gravity = gravity.value_or(Eigen::Vector3d::Zero());
  return true;
}

void add_output_options(CLI::App& app, ReferenceOptions& options) {
  app.add_option("--probe", options.probes,
                 "vertex or selector whose displacements are recorded; may be repeated");
  app.add_option("--out", options.out, "folder for run.csv");
  app.add_option("--every", options.every, "record one step in so many")->capture_default_str();
  app.add_option(
      "--compare", options.compare,
      "basis file of this mesh: its reduced model moves alongside, by the same steps; may be "
      "repeated");
  app.add_option("--modes", options.modes, "use their first R coordinates")
      ->needs("--compare")
      ->configurable(false);
  app.add_flag("--json", options.json, "print one JSON object on stdout");
}

}  // namespace

std::variant<ReferenceOptions, int> parse_reference_line(int count, char** words) {
  ReferenceOptions options;
  std::vector<std::string> own;
  int at = 1;
  for (; at < count && std::string(words[at]) != "--"; ++at) own.emplace_back(words[at]);
  for (++at; at < count; ++at) options.petsc_options.emplace_back(words[at]);

  CLI::App app{
      "Moves the whole mesh, no basis: the full-order reference of a reduced model. From rest, "
      "under the default load (--load-at, --load-force) and gravity. Units are SI."};
  app.name("tremolo-precompute reference");
  app.failure_message(one_line_message);
  app.allow_config_extras(CLI::config_extras_mode::ignore_all);
  add_config_option(app,
                    "read options from a TOML file, also one made for the precompute: keys that "
                    "have no meaning here are ignored");
  SolidTexts texts;
  MotionTexts motion;
  std::string scheme = "avf";
  add_solid_options(app, texts);
  app.add_flag("--static", options.statics, "the equilibrium under the whole load, no motion");
  app.add_option("--scale", options.scale, "times the default load")->capture_default_str();
  add_world_options(app, options, motion);
  add_time_options(app, options, scheme);
  app.add_option("--tolerance", options.tolerance,
                 "of the solves: relative residual force in the energy norm")
      ->capture_default_str();
  app.add_option("--max-iterations", options.max_iterations, "Newton iterations of a solve")
      ->capture_default_str();
  add_output_options(app, options);

  const int usage = exit_code({ErrorKind::kUsage, ""});
  for (const char* flag : {"--gravity", "--load-force", "--spin", "--velocity"})
    if (!vectors_are_words(own, flag)) return usage;
  try {
    if (const std::optional<int> code = read_words(app, own)) return *code;
  } catch (const Failure& failure) {
    std::cerr << "tremolo-precompute: " << failure.what() << "\n";
    return exit_code(failure.error());
  }
  options.config_path = config_path(app);
  if (const std::optional<int> code = finish_solid_options(texts, options.solid)) return *code;
  if (!finish_motion_texts(motion, options)) return usage;
  options.time.scheme = scheme == "midpoint" ? TimeScheme::kMidpoint : TimeScheme::kAveragedField;
  return options;
}

}  // namespace tremolo
