#include "server/artifacts/artifact_store.h"

#include <gtest/gtest.h>

#include <fstream>

namespace granary::server {
namespace {

class ArtifactStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::path(testing::TempDir()) /
        ("artifacts-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::size_t files() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_))
      count += entry.is_regular_file();
    return count;
  }

  std::filesystem::path folder_;
};

TEST_F(ArtifactStoreTest, publishes_what_its_checksum_says) {
  ArtifactStore store(folder_);
  const std::string bytes = "twelve bytes";
  auto incoming = store.receive();
  ASSERT_TRUE(incoming.ok());
  ASSERT_TRUE((*incoming)->append(bytes.substr(0, 5)).ok());
  ASSERT_TRUE((*incoming)->append(bytes.substr(5)).ok());
  ASSERT_TRUE(store.publish(std::move(*incoming), {sha256_hex(bytes), bytes.size()}).ok());
  auto reader = store.open(sha256_hex(bytes));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(*(*reader)->read(7, 100), "bytes");
  EXPECT_EQ(*store.size_of(sha256_hex(bytes)), bytes.size());
}

TEST_F(ArtifactStoreTest, refuses_and_removes_what_was_damaged_on_the_way) {
  ArtifactStore store(folder_);
  auto incoming = store.receive();
  ASSERT_TRUE((*incoming)->append("twelve bytez").ok());
  EXPECT_EQ(store.publish(std::move(*incoming), {sha256_hex("twelve bytes"), 12}).error().code,
            ErrorCode::data_loss);
  EXPECT_EQ(files(), 0u);
}

TEST_F(ArtifactStoreTest, an_abandoned_upload_leaves_nothing) {
  {
    ArtifactStore store(folder_);
    auto incoming = store.receive();
    ASSERT_TRUE((*incoming)->append("half").ok());
  }
  EXPECT_EQ(files(), 0u);
  std::ofstream(folder_ / "incoming" / "left") << "by a killed server";
  ArtifactStore again(folder_);
  EXPECT_EQ(files(), 0u);
}

TEST_F(ArtifactStoreTest, sweeps_old_files_that_nothing_refers_to) {
  ArtifactStore store(folder_);
  for (const char* bytes : {"kept", "orphan"}) {
    auto incoming = store.receive();
    ASSERT_TRUE((*incoming)->append(bytes).ok());
    ASSERT_TRUE(store.publish(std::move(*incoming), {sha256_hex(bytes), std::string(bytes).size()}).ok());
  }
  EXPECT_EQ(store.sweep({sha256_hex("kept")}, std::chrono::hours(1)), 0u) << "both may just have arrived";
  EXPECT_EQ(store.sweep({sha256_hex("kept")}, std::chrono::seconds(-1)), 1u);
  EXPECT_TRUE(store.size_of(sha256_hex("kept")).ok());
  EXPECT_FALSE(store.size_of(sha256_hex("orphan")).ok());
}

TEST_F(ArtifactStoreTest, names_that_are_no_checksum_never_become_paths) {
  ArtifactStore store(folder_);
  for (const std::string& name : {std::string("../../etc/passwd"), std::string(),
                                  std::string(64, '/'), std::string(64, 'A')}) {
    EXPECT_EQ(store.open(name).error().code, ErrorCode::not_found);
    EXPECT_EQ(store.size_of(name).error().code, ErrorCode::not_found);
  }
}

}  // namespace
}  // namespace granary::server
