// Tables, pages, stored results and charts: the parts of every report.
#include "tests/lab/report/report.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/output/plot.h"
#include "tests/lab/work/failure.h"
#include "tests/lab/work/store.h"
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

// A reader of RFC 4180 that has no code in common with the writer.
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

// A report with every kind of part whose texts try to be HTML, a script and a mark of the template.
Report wild_report(const std::string& directory) {
  const std::string wild = "</script><!--<script> & \"it's\" `a<b` %REPORT% %SCRIPTS% \n";
  Report report(directory, "a < b " + wild, wild);
  report.section("<script>" + wild);
  report.heading(wild);
  report.paragraph("use `a<b` here, lone ` stays");
  report.table({{wild}, {{wild}}}, wild);
  report.figure({Chart{.title = wild,
                       .x_label = wild,
                       .y_label = wild,
                       .curves = {{wild, {1, 2}, {3, 4}, CurveStyle::kPoints, ""}}}},
                1, 300, wild);
  report.figure({CellChart{wild, wild, wild, {wild}, {wild}, {{0}}, {{wild}}, {{wild, "#000000"}}}},
                wild);
  report.criteria({{wild, "<= 1", "2 > 1", false, true}, {"", "", "", false, false}});
  return report;
}

// The report that the script of a page reads.
Json report_of(const std::string& html) {
  const std::string_view open = "<script id=\"report\" type=\"application/json\">";
  const std::size_t begin = html.find(open) + open.size();
  return Json::parse(html.substr(begin, html.find("</script", begin) - begin));
}

std::size_t count(const std::string& text, std::string_view what) {
  std::size_t times = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; ++at) ++times;
  return times;
}

TEST(Report, APageIsMadeOfItsFileAgainAndOfNothingElse) {
  const testing::TemporaryFolder folder;
  const std::string page = wild_report(folder.path()).write();
  const std::string again = folder.file("again.html"), file = folder.file("report.json");
  ASSERT_TRUE(page_of_file(file, again));
  EXPECT_EQ(read(again), read(page));
  const std::string wrong[] = {
      "{", "[]", R"({"title": "a", "subtitle": "b"})",
      R"({"title": "a", "subtitle": "b", "sections": [{"title": "c"}]})",
      R"({"title": "a", "subtitle": "b", "sections": [{"title": "c", "parts": [{"kind": "table"}]}]})"};
  for (const std::string& text : wrong) {
    folder.write("report.json", text);
    const Status status = page_of_file(file, folder.file("none.html"));
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().kind, ErrorKind::kContent);
    EXPECT_NE(status.error().message.find("report.json: "), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder.file("none.html")));
  }
}

TEST(Page, HoldsTheReportWhateverItsTextsSay) {
  testing::TemporaryFolder folder;
  const Report report = wild_report(folder.path());
  const std::string page = report.write();
  EXPECT_EQ(page, folder.file("index.html"));
  const std::string html = read(page);
  EXPECT_EQ(report_of(html), Json(report.json()));
  EXPECT_EQ(Json::parse(read(folder.file("report.json"))), Json(report.json()));
  EXPECT_EQ(count(html, "<script"), 2u) << "a text became an element";
  EXPECT_EQ(count(html, "</script"), 2u);
  EXPECT_EQ(html.find("http"), html.npos) << "a page must not fetch anything";
  EXPECT_EQ(count(report.json().dump(), "MISSED"), 1u);
}

TEST(Report, ATableIsWholeInItsFileAndWithoutRepeatsOnThePage) {
  testing::TemporaryFolder folder;
  Report report(folder.path(), "title", "subtitle");
  const Table table{{"a", "b"}, {{"1", "x"}, {"1", "y"}}};
  report.table(table, "caption", "t.csv", 1);
  EXPECT_EQ(read(folder.file("t.csv")), to_csv(table));
  const auto& part = report.json()["sections"][0]["parts"][0]["table"];
  EXPECT_EQ(part["rows"].dump(), R"([["1","x"],["","y"]])");
  EXPECT_EQ(part["csv"], "t.csv");
}

TEST(Page, OnlyADecidingCriterionThatIsMissedFails) {
  EXPECT_EQ(exit_code(std::vector<Criterion>{}), 0);
  EXPECT_EQ(exit_code(std::vector<Criterion>{{"", "", "", true, true}, {"", "", "", false, false}}),
            0);
  EXPECT_EQ(exit_code(std::vector<Criterion>{{"", "", "", false, true}}), 6);
}

TEST(Page, WhatIsKnownLastCanBeReadFirst) {
  Report report(".", "title", "subtitle");
  report.section("one");
  report.paragraph("first body");
  report.section("two");
  report.paragraph("last body");
  report.last_section_first();
  const auto& sections = report.json()["sections"];
  EXPECT_EQ(sections[0]["title"], "two");
  EXPECT_EQ(sections[0]["parts"][0]["paragraph"], "last body");
  EXPECT_EQ(sections[1]["title"], "one");
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
  EXPECT_EQ(shorter.rows[2], table.rows[2]);  // x is under another 'a'
}

struct StoreTest : ::testing::Test {
  testing::TemporaryFolder folder;
  Store store = *Store::open(folder.file("deep/down"));
  std::string file = folder.file("deep/down/piece.json");
  int made = 0;

  Json get(const Json& key, double value = 0.1) {
    return store.get("piece", key, [&] {
      ++made;
      return Json{{"value", value}};
    });
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
  try {
    store.get("piece", 1, []() -> Json { throw Failure(content_error("no")); });
    ADD_FAILURE() << "nothing failed";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error.message, "no");
  }
  EXPECT_FALSE(std::ifstream(file));
  EXPECT_THROW(store.get("../escape", 1, [] { return Json(); }), Failure);
}

struct Numbers {
  double one = 0.0;
  std::optional<double> maybe;
  std::vector<double> many;
  Eigen::VectorXd vector;
  long whole = 0;
  std::string text;
};
template <class Archive>
void fields(Archive& archive, Numbers& n) {
  archive("one", n.one);
  archive("maybe", n.maybe);
  archive("many", n.many);
  archive("vector", n.vector);
  archive("whole", n.whole);
  archive("text", n.text);
}

TEST_F(StoreTest, FieldsComeBackAndWhatIsNotFiniteIsNoNumber) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Numbers numbers{1.0 / 3.0, infinity, {1e-300, kNan}, Eigen::Vector2d(2, 3), 7, "seven"};
  for (int start = 0; start < 2; ++start) {
    const Numbers back = store.get_as<Numbers>("fields", 1, [&] {
      ++made;
      return numbers;
    });
    EXPECT_EQ(back.one, numbers.one);
    EXPECT_FALSE(back.maybe);
    ASSERT_EQ(back.many.size(), 2u);
    EXPECT_EQ(back.many[0], 1e-300);
    EXPECT_TRUE(std::isnan(back.many[1]));
    EXPECT_EQ(back.vector, numbers.vector);
    EXPECT_EQ(back.whole, 7);
    EXPECT_EQ(back.text, "seven");
  }
  EXPECT_EQ(made, 1);
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

TEST(ChartJson, LogarithmicAxesLeaveGapsWhereNothingIsPositive) {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y", .log_x = true, .log_y = true};
  chart.curves = {{"c", {1, 2, 3, 4, 5, 0}, {1, 0, 10, -3, 100, 7}, CurveStyle::kLines, ""}};
  const Json drawn = to_json(chart);
  EXPECT_EQ(drawn["curves"][0]["x"], Json({1.0, nullptr, 3.0, nullptr, 5.0, nullptr}));
  EXPECT_EQ(drawn["curves"][0]["y"], Json({1.0, nullptr, 10.0, nullptr, 100.0, nullptr}));
  chart.log_x = chart.log_y = false;
  chart.curves[0].y[1] = kNan;
  const Json linear = to_json(chart);
  EXPECT_EQ(linear["curves"][0]["x"], Json({1.0, nullptr, 3.0, 4.0, 5.0, 0.0}));
  EXPECT_EQ(linear["curves"][0]["y"], Json({1.0, nullptr, 10.0, -3.0, 100.0, 7.0}));
}

TEST(ChartJson, SaysHowItIsDrawnWithNineDigits) {
  const Chart chart{.title = "t",
                    .x_label = "x",
                    .log_y = true,
                    .x_range = {{0.0, 2.0}},
                    .curves = {{"c", {1.0 / 3.0}, {1e-12 / 3.0}, CurveStyle::kDashes, "#123456"}}};
  const Json json = to_json(chart);
  EXPECT_EQ(json["x_range"], Json({0.0, 2.0}));
  EXPECT_TRUE(json["y_range"].is_null());
  EXPECT_FALSE(json["log_x"].get<bool>());
  EXPECT_TRUE(json["log_y"].get<bool>());
  const Json& curve = json["curves"][0];
  EXPECT_EQ(curve["style"], "dashes");
  EXPECT_EQ(curve["colour"], "#123456");
  EXPECT_EQ(curve["x"][0].dump(), "0.333333333");
  EXPECT_EQ(curve["y"][0].get<double>(), 3.33333333e-13);
}

}  // namespace
}  // namespace tremolo
