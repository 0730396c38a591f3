#include <filesystem>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/tremolo.h"
#include "tests/support/run_program.h"
#include "tests/support/sample_basis.h"
#include "tests/support/temporary_folder.h"

extern "C" int tremolo_c_recording(const char* model_path, const char* glb, const char* mdd,
                                   const char* bad);

namespace tremolo {
namespace {

TEST(CRecording, ABodyAndStatesGoIntoFiles) {
  const testing::TemporaryFolder folder;
  const auto strain = testing::random_strain_model(testing::spread_omega(4, 5.0, 900.0), 0.3, 71);
  const std::string model = folder.write("sample.tremolo", [&] {
    const auto bytes = *encode_basis(testing::sample_basis(strain));
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }());
  EXPECT_EQ(tremolo_c_recording(model.c_str(), folder.file("a.glb").c_str(),
                                folder.file("a.mdd").c_str(), folder.file("a.bvh").c_str()),
            0)
      << tremolo_last_error();
  EXPECT_TRUE(testing::slurp(folder.file("a.glb")).starts_with("glTF"));
  const std::string mdd = testing::slurp(folder.file("a-state.mdd"));
  ASSERT_GE(mdd.size(), 8U);
  EXPECT_EQ(mdd.substr(0, 4), std::string("\0\0\0\5", 4));
  EXPECT_TRUE(std::filesystem::exists(folder.file("a-body.obj")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.bvh")));
  EXPECT_EQ(tremolo_c_recording(model.c_str(), folder.file("b.html").c_str(),
                                folder.file("b.mdd").c_str(), folder.file("b.bvh").c_str()),
            0)
      << tremolo_last_error();
  const std::string page = testing::slurp(folder.file("b.html"));
  EXPECT_NE(page.find("\"kind\":\"film\""), page.npos);
  EXPECT_NE(page.find("\"name\":\"state\""), page.npos);
}

}  // namespace
}  // namespace tremolo
