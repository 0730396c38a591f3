// The files of an imported model are in the basis file only for the export.
#include <algorithm>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

using testing::tiny_basis;

BasisData imported() {
  BasisData data = tiny_basis();
  data.vega = {std::string("basis\0bytes", 11), "polynomials"};
  return data;
}

TEST(VegaSections, AreKeptByteForByteInBothEncodings) {
  for (BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
    const auto bytes = encode_basis(imported(), encoding);
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto reader = BasisReader::from_memory(*bytes);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_TRUE(reader->verify_all());
    const auto files = read_vega_files(*reader);
    ASSERT_TRUE(files) << files.error().message;
    EXPECT_EQ(files->basis, imported().vega.basis);
    EXPECT_EQ(files->cubic, imported().vega.cubic);
  }
}

TEST(VegaSections, ADamagedOneIsSeenByTheExportAlone) {
  std::vector<std::byte> bytes = *encode_basis(imported());
  const std::string word = "polynomials";
  const auto at = std::search(bytes.begin(), bytes.end(), word.begin(), word.end(),
                              [](std::byte a, char b) { return a == static_cast<std::byte>(b); });
  ASSERT_NE(at, bytes.end());
  *at = std::byte{0};
  auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(read_basis(*reader));
  const auto files = read_vega_files(*reader);
  ASSERT_FALSE(files);
  EXPECT_NE(files.error().message.find("vega_cubic"), std::string::npos) << files.error().message;
}

TEST(VegaSections, AModelOfTremolosOwnHasNone) {
  const std::vector<std::byte> bytes = *encode_basis(tiny_basis());
  auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->has("vega_basis"));
  const auto files = read_vega_files(*reader);
  ASSERT_TRUE(files);
  EXPECT_TRUE(files->basis.empty() && files->cubic.empty());
}

}  // namespace
}  // namespace tremolo
