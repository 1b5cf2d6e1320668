#include "worker/storage/result_writer.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/result_reader.h"
#include "tests/support/sample_result.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using namespace granary::testing;

TEST(ResultFile, every_dataset_has_units) {
  TemporaryDirectory directory;
  write_sample_result(directory / "r.h5");
  const StoredResult result = read_result(directory / "r.h5");
  EXPECT_GT(result.datasets.size(), 30u);
  for (const auto& [path, dataset] : result.datasets) EXPECT_NE(dataset.units, "") << path;
}

TEST(ResultFile, says_alone_how_it_was_made) {
  TemporaryDirectory directory;
  write_sample_result(directory / "r.h5");
  const StoredResult result = read_result(directory / "r.h5");
  EXPECT_EQ(result.texts.at("@format"), "granary-result");
  EXPECT_EQ(result.numbers.at("@format_version"), kResultFormatVersion);
  EXPECT_EQ(result.texts.at("@kind"), "discharge");
  EXPECT_EQ(result.texts.at("@state"), "complete");
  EXPECT_EQ(result.datasets.at("/scene").text(), "seed: 7\n");
  EXPECT_EQ(result.texts.at("/provenance@engine_version"), "1.0");
  EXPECT_EQ(result.texts.at("/provenance@vector_path"), "avx2");
  EXPECT_EQ(result.texts.at("/provenance@host"), "mill");
  EXPECT_EQ(result.texts.at("/provenance@date_utc"), "2026-11-22T05:00:00Z");
  EXPECT_EQ(result.numbers.at("/provenance@threads"), 2);
  EXPECT_EQ(result.numbers.at("/provenance@wall_s"), 1.25);
  EXPECT_EQ(result.datasets.at("/provenance/decisions/path").text(), "seed");
  EXPECT_EQ(result.datasets.at("/provenance/decisions/chosen_by").text(), "user");
  EXPECT_EQ(result.datasets.at("/provenance/warnings").text(), "beware");
}

TEST(ResultFile, keeps_values_errors_and_what_is_unknown_apart) {
  TemporaryDirectory directory;
  write_sample_result(directory / "r.h5");
  const StoredResult result = read_result(directory / "r.h5");
  const StoredDataset& f1 = result.datasets.at("/values/f1_m");
  EXPECT_EQ(f1.as<double>(), std::vector<double>{1.92});
  EXPECT_EQ(f1.units, "m");
  EXPECT_TRUE(f1.extents.empty());
  EXPECT_EQ(result.numbers.at("/values/f1_m@error"), 0.01);
  EXPECT_EQ(result.texts.at("/values/f1_m@error_basis"), "t-interval");
  EXPECT_FALSE(result.datasets.at("/values/f4_m").has_data);
  EXPECT_FALSE(result.numbers.contains("/values/f4_m@error"));
  EXPECT_EQ(result.texts.at("/values/f4_m@error_basis"), "nothing landed");
  EXPECT_EQ(result.datasets.at("/replicates/001/f1_m").as<double>(), std::vector<double>{2.5});
  EXPECT_EQ(result.numbers.at("/replicates/001@seed"), 99);
}

TEST(ResultFile, keeps_frames_series_fields_ledger_and_effects) {
  TemporaryDirectory directory;
  write_sample_result(directory / "r.h5");
  const StoredResult result = read_result(directory / "r.h5");
  EXPECT_EQ(result.numbers.at("/frames/000001@time_s"), 0.25);
  EXPECT_EQ(result.texts.at("/frames/000001@phase"), "rotation");
  const StoredDataset& position = result.datasets.at("/frames/000001/position_m");
  EXPECT_EQ(position.extents, (std::vector<unsigned long long>{3, 2}));
  EXPECT_EQ(position.as<double>()[0], 1);
  EXPECT_EQ(result.datasets.at("/frames/000001/radius_m").as<float>()[2], 0.005f);
  EXPECT_EQ(result.datasets.at("/series/remaining/time_s").units, "s");
  EXPECT_EQ(result.datasets.at("/fields/surface/streamwise_m_per_s").units, "m/s");
  EXPECT_EQ(result.datasets.at("/ledger/channels/friction").as<double>(),
            std::vector<double>{-2.0});
  EXPECT_EQ(result.datasets.at("/ledger/throughput").units, "J");
  EXPECT_EQ(result.numbers.at("/effects/gas@on"), 0);
  EXPECT_EQ(result.numbers.at("/effects/gas@number"), 0.023);
  EXPECT_EQ(result.numbers.at("/effects/gas@evaluations"), 0);
  EXPECT_FALSE(result.numbers.contains("/effects/gas@omitted_error"));
}

TEST(ResultFile, stores_a_column_that_does_not_change_only_once) {
  TemporaryDirectory directory;
  std::uintmax_t size[2];
  for (const bool constant : {false, true}) {
    ResultWriter writer(real_file_system(), directory / "r.h5");
    std::vector<double> radius(10000, 0.005);
    for (std::uint64_t i = 0; i < 10; ++i) {
      if (!constant) radius[i] = 1;
      writer.add_frame({i,
                        0.1 * static_cast<double>(i),
                        "",
                        {core::make_column<double>("radius_m", "m", radius)}});
    }
    writer.add_content({});
    writer.commit();
    size[constant] = std::filesystem::file_size(directory / "r.h5");
  }
  EXPECT_GT(size[false] - size[true], 9 * 80000u - 20000u);
  EXPECT_EQ(
      read_result(directory / "r.h5").datasets.at("/frames/000009/radius_m").as<double>().size(),
      10000u);
}

TEST(ResultFile, is_not_there_before_commit_and_leaves_nothing_behind) {
  TemporaryDirectory directory;
  {
    ResultWriter writer(real_file_system(), directory / "r.h5");
    writer.add_content({});
    EXPECT_FALSE(std::filesystem::exists(directory / "r.h5"));
    EXPECT_TRUE(std::filesystem::exists(directory / "r.h5.tmp"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory.path()));
}

TEST(ResultFile, in_a_directory_that_is_missing_is_an_error_with_its_path) {
  try {
    ResultWriter writer(real_file_system(), "/nonexistent/r.h5");
    FAIL() << "created a file in a missing directory";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("/nonexistent/r.h5"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace granary::storage
