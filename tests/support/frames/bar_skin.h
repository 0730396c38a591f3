// A bar and the surface that is drawn for it, for tests that start the programs.
#pragma once

#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/programs.h"

namespace tremolo::testing {

// The bar of box_mesh({8, 2, 2}, {0.4, 0.05, 0.06}), precomputed.
inline const std::string kBar =
    "bar.veg --young 2e6 --density 1000 --linear-modes 4 --modes 6 --order 1 ";

// A box in centimetres around the bar of 0.4 x 0.05 x 0.06 m, 1 mm away from it, its ends 0.5 mm:
// four sides with texture coordinates that close in a seam, and two lids of another material and
// object.
inline std::string skin() {
  std::ostringstream text;
  const double y[] = {-0.1, 5.1, 5.1, -0.1}, z[] = {-0.1, -0.1, 6.1, 6.1};
  const char* const normals[] = {"0 0 -1", "0 1 0", "0 0 1", "0 -1 0", "-1 0 0", "1 0 0"};
  for (const double x : {-0.05, 40.05})
    for (int k = 0; k < 4; ++k) text << "v " << x << " " << y[k] << " " << z[k] << "\n";
  for (int u = 0; u <= 4; ++u) text << "vt " << 0.25 * u << " 0\nvt " << 0.25 * u << " 1\n";
  for (const char* normal : normals) text << "vn " << normal << "\n";
  text << "o sides\nusemtl rubber\n";
  for (int k = 0; k < 4; ++k) {
    const int a = k + 1, b = (k + 1) % 4 + 1, t = 2 * k + 1, n = k + 1;
    const auto corner = [&](int v, int uv) { text << " " << v << "/" << uv << "/" << n; };
    text << "f";
    corner(b, t + 2), corner(a, t), corner(a + 4, t + 1), corner(b + 4, t + 3);
    text << "\n";
  }
  text << "o foot\nusemtl steel\nf 1/1/5 2/1/5 3/1/5 4/1/5\n";
  text << "o tip\nusemtl steel\nf 8/1/6 7/1/6 6/1/6 5/1/6\n";
  return text.str();
}

// Writes bar.veg, skin.obj and, by the precompute, bar.tremolo into the folder: fixed at its foot,
// loaded at the upper edge of its tip.
inline ProgramResult make_drawn_bar(const std::string& folder) {
  write_veg(folder + "/bar.veg", box_mesh({8, 2, 2}, {0.4, 0.05, 0.06}));
  std::ofstream(folder + "/skin.obj") << skin();
  return run_program(folder, kPrecompute + kBar +
                                 "-o bar.tremolo --render skin.obj --unit cm --fix foot "
                                 "--load-at 'tip and z>99%' --load-force 0,0,-1");
}

}  // namespace tremolo::testing
