// Tables, pages, stored results and charts: what every report is made of.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numeric>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/lab/report/chart.h"
#include "tests/lab/report/page.h"
#include "tests/lab/report/store.h"
#include "tests/lab/report/table.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Json = nlohmann::json;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// A reader of RFC 4180 that shares nothing with the writer.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      rows.back().back() += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && c == ',')
      rows.back().emplace_back();
    else if (!quoted && c == '\n')
      rows.push_back({""});
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

TEST(Table, CommasQuotesAndLineBreaksSurviveCsv) {
  const Table table{{"plain", "a,b"}, {{"say \"no\"", "two\nlines"}, {"", "\r\n"}, {"x", "1"}}};
  const auto rows = parse_csv(to_csv(table));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0], table.columns);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(rows[i + 1], table.rows[i]);
}

TEST(Table, WhatIsNotFiniteIsAnEmptyCell) {
  EXPECT_EQ(cell(kNan), "");
  EXPECT_EQ(cell(-std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(cell(0.000123456, 3), "0.000123");
}

TEST(Page, TextIsEscapedAndPicturesAreNot) {
  testing::TemporaryFolder folder;
  Page page("a < b", "x & \"y\"");
  page.section("<script>");
  page.paragraph("use `a<b` here, lone ` stays");
  page.table({{"<th>"}, {{"<td>"}}});
  page.figure("<svg></svg>", "caption & more");
  page.criteria({{"what <", "<= 1", "2 > 1", false, true}, {"", "", "", false, false}});
  ASSERT_TRUE(page.write(folder.file("index.html")));
  const std::string html = read(folder.file("index.html"));
  EXPECT_EQ(html.find("<script>"), html.npos);
  EXPECT_NE(html.find("&lt;td&gt;</td>"), html.npos);
  EXPECT_NE(html.find("<code>a&lt;b</code> here, lone ` stays"), html.npos);
  EXPECT_NE(html.find("<svg></svg>"), html.npos);
  EXPECT_NE(html.find("&lt;= 1"), html.npos);
  EXPECT_NE(html.find("MISSED"), html.npos);
  EXPECT_EQ(html.find("http"), html.npos) << "a page must not fetch anything";
}

TEST(Page, OnlyADecidingCriterionThatIsMissedFails) {
  EXPECT_EQ(exit_code(std::vector<Criterion>{}), 0);
  EXPECT_EQ(exit_code(std::vector<Criterion>{{"", "", "", true, true}, {"", "", "", false, false}}),
            0);
  EXPECT_EQ(exit_code(std::vector<Criterion>{{"", "", "", false, true}}), 6);
}

TEST(Page, WhatIsKnownLastCanBeReadFirst) {
  testing::TemporaryFolder folder;
  Page page("title", "subtitle");
  page.section("one");
  page.paragraph("first body");
  page.section("two");
  page.paragraph("last body");
  page.last_section_first();
  ASSERT_TRUE(page.write(folder.file("index.html")));
  const std::string html = read(folder.file("index.html"));
  EXPECT_LT(html.find("last body"), html.find("first body"));
  // The contents lead to the headings of the same name.
  EXPECT_NE(html.find("<a href=\"#section-1\">two</a>"), html.npos);
  EXPECT_NE(html.find("<h2 id=\"section-1\">two</h2>"), html.npos);
  EXPECT_NE(html.find("<h2 id=\"section-2\">one</h2>"), html.npos);
}

TEST(Criteria, TheVerdictCountsOnlyWhatDecides) {
  const Criterion met{"a", "", "", true}, missed{"b", "", "", false},
      shown{"c", "", "", false, false}, elsewhere{"d", "", "", false, false, true};
  EXPECT_EQ(verdict(missed), "MISSED");
  EXPECT_EQ(verdict(elsewhere), "elsewhere");
  EXPECT_EQ(verdict(std::vector{met, missed, shown, elsewhere}),
            "1 of 2 criteria are met; missed: b. Shown without a bound: 1. Measured by another "
            "command: 1.");
  EXPECT_EQ(exit_code({met, shown, elsewhere}), 0);
}

TEST(TableText, RepeatsAreLeftOutOnlyBehindRepeats) {
  const Table table{{"a", "b", "c"}, {{"1", "x", "p"}, {"1", "x", "p"}, {"2", "x", "p"}}};
  const Table shorter = without_repeats(table, 2);
  EXPECT_EQ(shorter.rows[0], table.rows[0]);
  EXPECT_EQ(shorter.rows[1], (std::vector<std::string>{"", "", "p"}));
  EXPECT_EQ(shorter.rows[2], table.rows[2]);  // x stands under another 'a'
}

struct StoreTest : ::testing::Test {
  testing::TemporaryFolder folder;
  Store store = *Store::open(folder.file("deep/down"));
  std::string file = folder.file("deep/down/piece.json");
  int made = 0;

  Json get(const Json& key, double value = 0.1) {
    Result<Json> result = store.get("piece", key, [&]() -> Result<Json> {
      ++made;
      return Json{{"value", value}};
    });
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return result ? *result : Json();
  }
};

TEST_F(StoreTest, ASecondStartReadsWhatTheFirstMade) {
  const Json first = get({{"step", 0.003}}, 1.0 / 3.0);
  store = *Store::open(folder.file("deep/down"));
  EXPECT_EQ(get({{"step", 0.003}}, 7.0), first);
  EXPECT_EQ(first["value"].get<double>(), 1.0 / 3.0);
  EXPECT_EQ(made, 1);
}

TEST_F(StoreTest, AnotherKeyIsMadeAnew) {
  get({{"step", 0.003}});
  EXPECT_EQ(get({{"step", 0.001}}, 2.0)["value"], 2.0);
  EXPECT_EQ(made, 2);
}

TEST_F(StoreTest, EveryDamageOfTheFileIsNoticed) {
  get({{"step", 0.003}}, 0.123456789);
  const std::string whole = read(file);
  for (std::size_t i = 0; i + 1 < whole.size(); ++i) {  // the last byte is a line break
    std::ofstream(file, std::ios::binary) << whole.substr(0, i);
    made = 0;
    get({{"step", 0.003}}, 0.123456789);
    EXPECT_EQ(made, 1) << "cut to " << i << " bytes";
    if (whole[i] < '0' || whole[i] > '9') continue;
    std::string changed = whole;
    changed[i] = whole[i] == '5' ? '6' : '5';
    std::ofstream(file, std::ios::binary) << changed;
    made = 0;
    get({{"step", 0.003}}, 0.123456789);
    EXPECT_EQ(made, 1) << "digit " << i << " changed";
  }
  EXPECT_EQ(read(file), whole);
}

TEST_F(StoreTest, WorkThatFailsLeavesNothing) {
  Result<Json> result = store.get("piece", 1, [] { return Result<Json>(content_error("no")); });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "no");
  EXPECT_FALSE(std::ifstream(file));
  EXPECT_FALSE(store.get("../escape", 1, [] { return Result<Json>(Json()); }));
}

TEST(Thin, KeepsEndsAndExtremes) {
  std::vector<double> x(10000), y(x.size());
  std::iota(x.begin(), x.end(), 0.0);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(0.7 * x[i]) * (1.0 + 1e-4 * x[i]);
  y[4321] = 99.0;
  y[8765] = -77.0;
  y[0] = kNan;
  std::vector<double> kept_x = x, kept_y = y;
  thin(kept_x, kept_y, 100);
  EXPECT_LE(kept_x.size(), 400u);
  EXPECT_EQ(kept_x.size(), kept_y.size());
  EXPECT_EQ(kept_x.front(), 0.0);
  EXPECT_EQ(kept_x.back(), x.back());
  EXPECT_TRUE(std::is_sorted(kept_x.begin(), kept_x.end()));
  for (std::size_t b = 0; b < 100; ++b) {  // every bucket's own extremes, not only the whole's
    double low = 1e9, high = -1e9, kept_low = 1e9, kept_high = -1e9;
    for (std::size_t i = 100 * b; i < 100 * b + 100; ++i) {
      low = std::min(low, std::isnan(y[i]) ? low : y[i]);
      high = std::max(high, std::isnan(y[i]) ? high : y[i]);
    }
    for (std::size_t i = 0; i < kept_x.size(); ++i)
      if (kept_x[i] >= 100.0 * static_cast<double>(b) &&
          kept_x[i] < 100.0 * static_cast<double>(b + 1) && !std::isnan(kept_y[i])) {
        kept_low = std::min(kept_low, kept_y[i]);
        kept_high = std::max(kept_high, kept_y[i]);
      }
    EXPECT_EQ(low, kept_low);
    EXPECT_EQ(high, kept_high);
  }
}

TEST(Thin, LeavesShortSeriesAlone) {
  std::vector<double> x = {1, 2, 3}, y = {4, 5, 6};
  thin(x, y, 1000);
  EXPECT_EQ(x.size(), 3u);
}

std::string without_ids(const std::string& svg) {
  return std::regex_replace(svg, std::regex("chart[0-9]+-"), "");
}

struct ChartTest : ::testing::Test {
  void SetUp() override {
    if (std::system("gnuplot --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no gnuplot";
  }
};

TEST_F(ChartTest, LogarithmicAxesDropWhatIsNotPositive) {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y", .log_x = true, .log_y = true};
  chart.curves = {{"c", {1, 2, 3, 4, 5, 0}, {1, 0, 10, -3, 100, 7}, CurveStyle::kLines, ""}};
  Chart clean = chart;
  clean.curves[0].x = {1, kNan, 3, 4, 5, kNan};
  clean.curves[0].y = {1, 5, 10, kNan, 100, 7};
  const Result<std::string> drawn = draw_svg({chart}, 1), expected = draw_svg({clean}, 1);
  ASSERT_TRUE(drawn && expected);
  EXPECT_EQ(without_ids(*drawn), without_ids(*expected));
  chart.log_x = chart.log_y = false;
  EXPECT_NE(without_ids(*draw_svg({chart}, 1)), without_ids(*expected));
}

TEST_F(ChartTest, TwoDrawingsShareNoId) {
  const Chart chart{.title = "t",
                    .curves = {{"c", {1, 2}, {3, 4}, CurveStyle::kLinesAndPoints, ""}}};
  const CellChart cells{
      .columns = {"1"}, .rows = {"2"}, .values = {{0}}, .classes = {{"ok", "#117733"}}};
  const std::string both = *draw_svg({chart}, 1) + *draw_svg({chart}, 1) + *draw_svg(cells);
  const std::regex id(" id=['\"]([^'\"]*)"), use("#(chart[^'\")]*)['\")]");
  std::vector<std::string> ids;
  for (std::sregex_iterator i(both.begin(), both.end(), id), end; i != end; ++i)
    ids.push_back((*i)[1]);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
  int uses = 0;
  for (std::sregex_iterator i(both.begin(), both.end(), use), end; i != end; ++i, ++uses)
    EXPECT_TRUE(std::binary_search(ids.begin(), ids.end(), (*i)[1].str())) << (*i)[1];
  EXPECT_GT(uses, 0);
  EXPECT_TRUE(both.starts_with("<svg"));
}

TEST_F(ChartTest, AnyTextAndAnyDataCanBeDrawn) {
  const std::string wild = "it's _1_ ^{2} @ \"3\" & <4> \\n \n `date`";
  Chart chart{.title = wild, .x_label = wild, .y_label = wild, .log_y = true};
  for (std::vector<double> y : {std::vector<double>{}, {kNan, kNan}, {-1, -2}, {2, 2}, {0, 3}})
    chart.curves.push_back({wild, std::vector<double>(y.size(), 1.0), y, CurveStyle::kPoints, ""});
  EXPECT_TRUE(draw_svg({chart}, 1));
  for (const Curve& curve : chart.curves) {
    const Chart one{.log_x = true, .curves = {curve}};
    EXPECT_TRUE(draw_svg({one, one, one}, 2));
  }
  const CellChart cells{wild, wild, wild, {wild}, {wild}, {{0}}, {{wild}}, {{wild, "#000000"}}};
  EXPECT_TRUE(draw_svg(cells));
}

TEST(Gnuplot, MissingItIsASystemError) {
  const char* before = std::getenv("PATH");
  const std::string path = before == nullptr ? "" : before;
  ::setenv("PATH", "", 1);
  const Result<std::string> drawn = draw_svg({Chart{}}, 1);
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().kind, ErrorKind::kSystem);
  EXPECT_NE(drawn.error().message.find("not installed"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
