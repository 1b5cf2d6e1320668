#include "worker/storage/checkpoint.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/faulty_file_system.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using testing::FaultyFileSystem;
using testing::TemporaryDirectory;

const RunIdentity kIdentity{"scene", "1.0", "portable"};

Checkpoint numbered(double number) {
  Checkpoint checkpoint;
  checkpoint.identity = kIdentity;
  checkpoint.segments = {{"segment-000000", 0, 0, 3, 100, 42}};
  checkpoint.run = {std::byte{1}, std::byte{2}};
  checkpoint.engine.put_scalar("number", "1", number);
  return checkpoint;
}

std::optional<Checkpoint> load(const Path& directory, std::vector<std::string>* reports = nullptr,
                               const RunIdentity& identity = kIdentity) {
  return load_checkpoint(
      real_file_system(), directory, identity, [](const Checkpoint&) {},
      [&](const std::string& reason) {
        if (reports != nullptr) reports->push_back(reason);
      });
}

double number_in(const std::optional<Checkpoint>& checkpoint) {
  return checkpoint ? checkpoint->engine.get_scalar<double>("number") : -1;
}

TEST(Checkpoint, comes_back_as_it_was_saved) {
  TemporaryDirectory directory;
  save_checkpoint(real_file_system(), directory.path(), numbered(1.5));
  const auto back = load(directory.path());
  ASSERT_TRUE(back);
  EXPECT_EQ(number_in(back), 1.5);
  EXPECT_EQ(back->run, numbered(0).run);
  ASSERT_EQ(back->segments.size(), 1u);
  EXPECT_EQ(back->segments[0].name, "segment-000000");
  EXPECT_EQ(back->segments[0].frame_count, 3u);
  EXPECT_EQ(back->segments[0].checksum, 42u);
}

TEST(Checkpoint, of_another_scene_engine_or_vector_path_is_refused) {
  TemporaryDirectory directory;
  save_checkpoint(real_file_system(), directory.path(), numbered(1));
  for (const RunIdentity& other :
       {RunIdentity{"other", "1.0", "portable"}, RunIdentity{"scene", "1.1", "portable"},
        RunIdentity{"scene", "1.0", "avx2"}}) {
    std::vector<std::string> reports;
    EXPECT_FALSE(load(directory.path(), &reports, other));
    ASSERT_EQ(reports.size(), 1u);
    EXPECT_NE(reports[0].find("belongs to another"), std::string::npos) << reports[0];
  }
}

TEST(Checkpoint, with_any_byte_changed_gives_way_to_the_one_before) {
  TemporaryDirectory directory;
  save_checkpoint(real_file_system(), directory.path(), numbered(1));
  save_checkpoint(real_file_system(), directory.path(), numbered(2));
  const Path newest = directory / "checkpoint";
  const auto size = std::filesystem::file_size(newest);
  for (std::uint64_t offset = 0; offset < size; ++offset) {
    std::fstream file(newest, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset));
    const char good = static_cast<char>(file.get());
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(static_cast<char>(good ^ 1)).flush();
    std::vector<std::string> reports;
    EXPECT_EQ(number_in(load(directory.path(), &reports)), 1) << "byte " << offset;
    EXPECT_EQ(reports.size(), 1u);
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(good).flush();
  }
  EXPECT_EQ(number_in(load(directory.path())), 2);
}

TEST(Checkpoint, cut_at_any_length_gives_way_to_the_one_before) {
  TemporaryDirectory directory;
  save_checkpoint(real_file_system(), directory.path(), numbered(1));
  save_checkpoint(real_file_system(), directory.path(), numbered(2));
  for (auto length = std::filesystem::file_size(directory / "checkpoint"); length-- > 0;) {
    std::filesystem::resize_file(directory / "checkpoint", length);
    EXPECT_EQ(number_in(load(directory.path())), 1) << "cut at " << length;
  }
}

TEST(Checkpoint, survives_a_fault_at_any_operation_of_saving_the_next) {
  for (const bool lose : {false, true}) {
    for (std::uint64_t at = 0;; ++at) {
      TemporaryDirectory directory;
      const Path run = directory / "run";
      real_file_system().create_directory(run);
      save_checkpoint(real_file_system(), run, numbered(1));
      save_checkpoint(real_file_system(), run, numbered(2));
      FaultyFileSystem files(FaultyFileSystem::Fault::power_cut, at, directory / "scratch");
      try {
        save_checkpoint(files, run, numbered(3));
      } catch (const StorageError&) {
      }
      if (lose) files.lose_unsynced(run);
      const double number = number_in(load(run));
      if (!files.struck()) {
        EXPECT_EQ(number, 3);
        EXPECT_GE(at, 8u);
        break;
      }
      EXPECT_TRUE(number == 2 || number == 3) << "at " << at << ": " << number;
    }
  }
}

TEST(Checkpoint, counts_only_when_its_segments_are_accepted) {
  TemporaryDirectory directory;
  save_checkpoint(real_file_system(), directory.path(), numbered(1));
  save_checkpoint(real_file_system(), directory.path(), numbered(2));
  int calls = 0;
  const auto accepted = load_checkpoint(
      real_file_system(), directory.path(), kIdentity,
      [&](const Checkpoint&) {
        if (++calls == 1) throw StorageError(StorageFault::damaged, "torn segment");
      },
      [](const std::string&) {});
  EXPECT_EQ(number_in(accepted), 1);
}

}  // namespace
}  // namespace granary::storage
