#include "precompute/tets/tets_options.h"

#include <iostream>
#include <vector>

#include "common/result.h"
#include "formats/file/command_words.h"
#include "precompute/options/solid_options.h"
#include "precompute/system/failure.h"
#include "precompute/system/option_checks.h"

namespace tremolo {
std::variant<TetsOptions, int> parse_tets_line(int count, char** words) {
  TetsOptions options;
  options.command_line = settings_text("tets", count, words);
  CLI::App app{
      "Writes a mesh of tetrahedra for the engine, whose elements are moved themselves: "
      "mesh, materials, held vertices, the drawn surface. Units are SI."};
  app.name("tremolo-precompute tets");
  app.failure_message(one_line_message);
  app.allow_config_extras(CLI::config_extras_mode::error);
  add_config_option(app, "read options from a TOML file (keys are the long flag names)");
  SolidTexts texts;
  add_solid_options(app, texts);
  // These flags apply to a basis and its loads; the engine chooses the elements' order.
  for (const char* other : {"--load-force", "--load-at", "--mass", "--order", "--point-mass",
                            "--surface-subdivide", "--fix-x", "--fix-y", "--fix-z"})
    app.remove_option(app.get_option(other));
  app.add_option("-o,--output", options.output_path, "the file of tetrahedra")->required();
  app.add_option("--render", texts.render,
                 "surface that is drawn in place of the mesh's boundary and moves with it");
  app.add_option("--cells", options.cells,
                 "of the grid of distances at rest, by which bodies touch, along the longest side "
                 "of the drawn surface; 0: none")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("--json", options.json, "print one JSON object on stdout");

  try {
    if (const std::optional<int> code = read_words(app, count, words)) return *code;
  } catch (const Failure& failure) {
    std::cerr << app.get_name() << ": " << printable(failure.what()) << "\n";
    return exit_code(failure.error());
  }
  options.config_path = config_path(app);
  texts.order = "1";
  if (const std::optional<int> code = finish_solid_options(texts, options.solid)) return *code;
  return options;
}

}  // namespace tremolo
