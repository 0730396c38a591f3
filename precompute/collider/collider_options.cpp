#include "precompute/collider/collider_options.h"

#include <algorithm>
#include <iostream>
#include <thread>
#include <vector>

#include "common/distance/distance_grid.h"
#include "common/result.h"
#include "common/units.h"
#include "formats/file/command_words.h"
#include "precompute/system/option_checks.h"

namespace tremolo {
std::variant<ColliderOptions, int> parse_collider_line(int count, char** words) {
  ColliderOptions options;
  options.command_line = settings_text("collider", count, words);
  options.threads = std::max(1U, std::thread::hardware_concurrency());

  CLI::App app{
      "Makes a collider: the signed distances of a surface on a grid, for bodies to bump into. "
      "Units are SI."};
  app.name("tremolo-precompute collider");
  app.failure_message(one_line_message);
  std::string up = "z";
  app.add_option("surface", options.surface_path,
                 "OBJ, PLY, STL, OFF, glTF, FBX, ...; of a tetrahedral mesh its boundary")
      ->required();
  app.add_option("-o,--output", options.output_path, "the collider file")->required();
  app.add_option("--cells", options.cells,
                 "of the grid along the longest side of the surface's box (default: from 64 to "
                 "256, as many as "
                 "keep the error below 0.5 % of that side and miss no thin wall)")
      ->check(CLI::Range(4, static_cast<int>(kMostGridNodes)));
  app.add_option("--margin", options.margin,
                 "m around the surface that the grid covers, three cells at least (default: 5 % of "
                 "the longest side)")
      ->check(above_zero());
  app.add_option("--unit", options.unit,
                 std::string("of the coordinates: ") + kLengthUnits +
                     " (default: what the file says, or metres)");
  app.add_option("--up", up,
                 "the axis that points up; y turns the surface: (x, y, z) -> (x, -z, y)")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  app.add_flag("--fill-holes", options.fill_holes, "close holes of every size");
  app.add_option("--threads", options.threads, "threads")->check(thread_count());
  app.add_flag("--json", options.json, "print one JSON object on stdout");

  const int usage = exit_code(ErrorKind::kUsage);
  if (const std::optional<int> code = read_words(app, count, words)) return *code;
  options.y_up = up == "y";
  if (options.unit.empty()) return options;
  if (const Result<double> metres = metres_per_unit(options.unit); !metres) {
    std::cerr << "tremolo-precompute collider: --unit: " << metres.error().message << "\n";
    return usage;
  }
  return options;
}

}  // namespace tremolo
