#include "worker/storage/segment.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/faulty_file_system.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/frame_store.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using testing::FaultyFileSystem;
using testing::TemporaryDirectory;

const RunIdentity kIdentity{"scene", "1.0", "portable"};

void append_frame(FrameStore& store, std::uint64_t index) {
  const std::vector<double> position(20, 0.5 * static_cast<double>(index));
  const core::ColumnView column{"position_m", "m", core::ElementType::f64, 10, 2, position.data()};
  store.append({index, 0.1 * static_cast<double>(index), "flow", std::span(&column, 1)});
}

std::vector<std::uint64_t> indices_in(FrameStore& store) {
  std::vector<std::uint64_t> indices;
  store.for_each([&](const Frame& frame) {
    EXPECT_EQ(frame.columns.at(0).as<double>()[19], 0.5 * static_cast<double>(frame.index));
    indices.push_back(frame.index);
  });
  return indices;
}

void flip_byte(const Path& path, std::uint64_t offset) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  const char byte = static_cast<char>(file.get() ^ 0x10);
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(byte);
}

TEST(FrameStore, keeps_frames_in_order_across_segments_and_reopening) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "scene text");
  append_frame(store, 0);
  append_frame(store, 1);
  store.seal();
  append_frame(store, 2);
  EXPECT_EQ(indices_in(store), (std::vector<std::uint64_t>{0, 1, 2}));  // the open one included

  const std::vector<SegmentInfo> sealed = store.seal();
  ASSERT_EQ(sealed.size(), 2u);
  EXPECT_EQ(sealed[1].first_frame, 2u);
  FrameStore again(real_file_system(), directory.path(), kIdentity, "scene text");
  again.restore(sealed);
  append_frame(again, 3);
  EXPECT_EQ(indices_in(again), (std::vector<std::uint64_t>{0, 1, 2, 3}));
}

TEST(FrameStore, drops_what_came_after_the_checkpoint) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "");
  append_frame(store, 0);
  const std::vector<SegmentInfo> at_checkpoint = store.seal();
  append_frame(store, 1);
  store.seal();
  append_frame(store, 2);

  FrameStore resumed(real_file_system(), directory.path(), kIdentity, "");
  resumed.restore(at_checkpoint);
  EXPECT_EQ(real_file_system().list(directory.path()),
            (std::vector<std::string>{"segment-000000"}));
  append_frame(resumed, 1);
  EXPECT_EQ(indices_in(resumed), (std::vector<std::uint64_t>{0, 1}));
}

TEST(FrameStore, goes_back_over_open_and_sealed_segments) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "");
  for (std::uint64_t index = 0; index < 3; ++index) append_frame(store, index);
  store.seal();
  append_frame(store, 3);
  store.seal();
  append_frame(store, 4);
  append_frame(store, 5);

  store.drop_from(5);  // in the open segment
  EXPECT_EQ(indices_in(store), (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  store.drop_from(2);  // across both sealed ones
  EXPECT_EQ(indices_in(store), (std::vector<std::uint64_t>{0, 1}));
  append_frame(store, 2);
  store.seal();
  EXPECT_EQ(indices_in(store), (std::vector<std::uint64_t>{0, 1, 2}));
  store.drop_from(0);
  EXPECT_TRUE(indices_in(store).empty());
  EXPECT_TRUE(real_file_system().list(directory.path()).empty());
}

TEST(FrameStore, what_is_sealed_survives_a_power_cut) {
  TemporaryDirectory directory;
  const Path run = directory / "run";
  FaultyFileSystem files(FaultyFileSystem::Fault::none, 0, directory / "scratch");
  files.create_directory(run);
  FrameStore store(files, run, kIdentity, "");
  append_frame(store, 0);
  const std::vector<SegmentInfo> sealed = store.seal();
  append_frame(store, 1);
  files.lose_unsynced(run);
  FrameStore after(real_file_system(), run, kIdentity, "");
  after.restore(sealed);
  EXPECT_EQ(indices_in(after), (std::vector<std::uint64_t>{0}));
}

TEST(FrameStore, refuses_a_sealed_segment_with_any_byte_changed_or_missing) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "text");
  append_frame(store, 0);
  append_frame(store, 1);
  const std::vector<SegmentInfo> sealed = store.seal();
  const Path path = directory.path() / sealed[0].name;
  for (std::uint64_t offset = 0; offset < sealed[0].size_bytes; ++offset) {
    flip_byte(path, offset);
    EXPECT_THROW(store.restore(sealed), StorageError) << "byte " << offset;
    flip_byte(path, offset);
  }
  EXPECT_NO_THROW(store.restore(sealed));
  std::filesystem::resize_file(path, sealed[0].size_bytes - 1);
  EXPECT_THROW(store.restore(sealed), StorageError);
  EXPECT_TRUE(std::filesystem::exists(path)) << "evidence must not be deleted by a refusal";
}

TEST(SegmentReader, gives_all_frames_before_a_cut_at_any_length_and_never_a_torn_one) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "");
  std::vector<std::uint64_t> size_after;
  const Path path = directory.path() / open_segment_name(0);
  for (std::uint64_t i = 0; i < 3; ++i) {
    append_frame(store, i);
    size_after.push_back(std::filesystem::file_size(path));
  }
  const Path copy = directory / "copy";
  for (std::uint64_t length = 0; length <= size_after.back(); ++length) {
    std::filesystem::copy_file(path, copy, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(copy, length);
    const auto whole = static_cast<std::size_t>(std::count_if(
        size_after.begin(), size_after.end(), [&](auto size) { return size <= length; }));
    std::size_t got = 0;
    try {
      SegmentReader reader(real_file_system(), copy);
      while (reader.next()) ++got;
      const bool at_record_end = whole > 0 && size_after[whole - 1] == length;
      EXPECT_TRUE(reader.torn() || at_record_end || whole == 0) << "cut at " << length;
    } catch (const StorageError& error) {
      EXPECT_EQ(error.fault(), StorageFault::damaged);
    }
    EXPECT_EQ(got, whole) << "cut at " << length;
  }
}

TEST(FrameStore, does_not_read_another_runs_segment) {
  TemporaryDirectory directory;
  FrameStore store(real_file_system(), directory.path(), kIdentity, "");
  append_frame(store, 0);
  const std::vector<SegmentInfo> sealed = store.seal();
  FrameStore other(real_file_system(), directory.path(), {"scene", "1.0", "avx2"}, "");
  other.restore(sealed);
  try {
    other.for_each([](const Frame&) {});
    FAIL() << "read a segment of another vector path";
  } catch (const StorageError& error) {
    EXPECT_EQ(error.fault(), StorageFault::foreign);
  }
}

}  // namespace
}  // namespace granary::storage
