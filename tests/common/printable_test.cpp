// Names from files cannot control the terminal on which they are printed.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "common/text.h"

namespace tremolo {
namespace {

using namespace std::string_literals;

TEST(Printable, WhatSteersATerminalIsToldAsItsBytes) {
  EXPECT_EQ(printable("\x1b[2J"), "\\x1b[2J");
  EXPECT_EQ(printable("a\0b"s), "a\\x00b");
  EXPECT_EQ(printable("\x7f\a\b"), "\\x7f\\x07\\x08");
  EXPECT_EQ(printable("\xc2\x9b"), "\\xc2\\x9b");           // CSI as UTF-8
  EXPECT_EQ(printable("\x9b"), "\\x9b");                    // and as a byte
  EXPECT_EQ(printable("\xe2\x80\xae"), "\\xe2\\x80\\xae");  // from right to left
  EXPECT_EQ(printable("\xc0\x9b\xff"), "\\xc0\\x9b\\xff");  // no UTF-8
  EXPECT_EQ(printable("one\rtwo"), "one\\x0dtwo");          // over what stands there
}

TEST(Printable, WordsOfAllLanguagesAndEndsOfLinesStay) {
  for (const char* text : {"plain", "two\nlines\tand more\n", "progress\r", "\u00e4\u00df\u20ac",
                           "\u6f22\u5b57", "\U0001F600", ""})
    EXPECT_EQ(printable(text), text);
}

TEST(Larger, ANumberThatIsNoneIsNeverHidden) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(larger(1.0, none)));
  EXPECT_TRUE(std::isnan(larger(none, 1.0)));
  EXPECT_EQ(larger(1.0, 2.0), 2.0);
  EXPECT_EQ(larger(2.0, 1.0), 2.0);
}

}  // namespace
}  // namespace tremolo
