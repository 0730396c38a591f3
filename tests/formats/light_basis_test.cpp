// Models without their inside, and sounds.
#include "formats/basis/light_basis.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/sound/wav_writer.h"
#include "tests/support/sample_basis.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

BasisData sample_data() {
  Eigen::VectorXd omega(3);
  omega << 10.0, 20.0, 50.0;
  return testing::sample_basis(testing::random_strain_model(omega, 0.2, 3));
}

TEST(LightBasis, KeepsTheBodyAndItsSurface) {
  BasisData data = sample_data();
  ASSERT_FALSE(data.interior.vertex_ids.empty());
  const Result<BasisData> light = without_interior(data);
  ASSERT_TRUE(light) << light.error().message;
  EXPECT_EQ(light->vertex_count, data.surface.vertex_ids.size());
  EXPECT_EQ(light->lambda, data.lambda);
  EXPECT_EQ(light->cubic, data.cubic);
  EXPECT_EQ(light->quartic, data.quartic);
  EXPECT_EQ(light->surface.rows, data.surface.rows);
  EXPECT_TRUE(light->interior.vertex_ids.empty());
  for (std::size_t i = 0; i < light->surface.vertex_ids.size(); ++i)
    EXPECT_EQ(light->surface.vertex_ids[i], static_cast<VertexId>(i));
  // Whoever is named is the same vertex under its new number.
  for (std::size_t i = 0; i < light->load.vertices.size(); ++i)
    EXPECT_EQ(data.surface.vertex_ids[light->load.vertices[i]], data.load.vertices[i]);
  for (const VertexId fixed : light->fixed_vertices)
    EXPECT_NE(std::find(data.fixed_vertices.begin(), data.fixed_vertices.end(),
                        data.surface.vertex_ids[fixed]),
              data.fixed_vertices.end());
  // It can be written and is read.
  const Result<std::vector<std::byte>> bytes = encode_basis(*light);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const Result<std::vector<std::byte>> whole = encode_basis(data);
  ASSERT_TRUE(whole);
  EXPECT_LT(bytes->size(), whole->size());
}

TEST(LightBasis, ALoadInsideIsLeftOut) {
  BasisData data = sample_data();
  data.load.vertices = {data.interior.vertex_ids.front()};
  data.load.forces = {{1.0, 2.0, 3.0}};
  const Result<BasisData> light = without_interior(data);
  ASSERT_TRUE(light);
  EXPECT_TRUE(light->load.vertices.empty());
  EXPECT_TRUE(light->load.forces.empty());
}

TEST(Wav, HoldsItsSamples) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.path() + "/sound.wav";
  const double samples[] = {0.0, 0.5, -1.0, 1.0, 7.0, -7.0};
  ASSERT_TRUE(write_wav(path, 48000, samples));
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(bytes.size(), 44U + 12U);
  const auto number = [&bytes](std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int k = count - 1; k >= 0; --k)
      value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(k)]);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4) + bytes.substr(8, 8), "RIFFWAVEfmt ");
  EXPECT_EQ(number(4, 4), 48U);
  EXPECT_EQ(number(24, 4), 48000U);
  EXPECT_EQ(number(40, 4), 12U);
  const int expected[] = {0, 16384, -32767, 32767, 32767, -32767};
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_EQ(static_cast<std::int16_t>(number(44 + 2 * k, 2)), expected[k]) << k;
  EXPECT_FALSE(write_wav(folder.path() + "/no/such/sound.wav", 48000, samples));
}

}  // namespace
}  // namespace tremolo
