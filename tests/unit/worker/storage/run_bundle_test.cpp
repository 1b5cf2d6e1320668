#include "worker/storage/run_bundle.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_directory.h"
#include "worker/storage/checkpoint.h"
#include "worker/storage/frame_store.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using testing::TemporaryDirectory;

const RunIdentity kIdentity{"scene", "1", "portable"};

class RunBundle : public ::testing::Test {
 protected:
  // A run with one sealed segment, a checkpoint, and another segment after it.
  void SetUp() override {
    FileSystem& files = real_file_system();
    files.create_directory(from);
    FrameStore frames(files, from, kIdentity, "scene text");
    const double value = 7;
    const core::ColumnView column{"x_m", "m", core::ElementType::f64, 1, 1, &value};
    frames.append({0, 0, "flow", std::span(&column, 1)});
    const auto segments = frames.seal();
    save_checkpoint(files, from, {kIdentity, segments, {}, {}});
    frames.append({1, 1, "flow", std::span(&column, 1)});
    frames.seal();
    pack_run(files, from, bundle);
  }

  std::optional<Checkpoint> load(const Path& where) {
    return load_checkpoint(
        real_file_system(), where, kIdentity,
        [&](const Checkpoint& checkpoint) {
          FrameStore(real_file_system(), where, kIdentity, "").restore(checkpoint.segments);
        },
        [](const std::string&) {});
  }

  TemporaryDirectory directory;
  const Path from = directory / "from";
  const Path to = directory / "to";
  const Path bundle = directory / "bundle";
};

TEST_F(RunBundle, holds_the_checkpoint_and_exactly_the_segments_it_lists) {
  unpack_run(real_file_system(), bundle, to);
  EXPECT_EQ(real_file_system().list(to), (std::vector<std::string>{"checkpoint", "segment-000000"}));
  EXPECT_TRUE(load(to));
}

TEST_F(RunBundle, with_any_byte_changed_or_cut_never_gives_a_checkpoint_that_fails_later) {
  std::ifstream in(bundle, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  const auto is_harmless = [&](const std::string& content) {
    std::ofstream(bundle, std::ios::binary) << content;
    try {
      unpack_run(real_file_system(), bundle, to);
    } catch (const StorageError&) {
    }
    return !load(to);  // e.g. a segment under another name: the checkpoint misses it
  };
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 4);
    EXPECT_TRUE(is_harmless(bad)) << "byte " << i;
    EXPECT_TRUE(is_harmless(good.substr(0, i))) << "cut at " << i;
  }
  EXPECT_FALSE(is_harmless(good));
}

TEST_F(RunBundle, never_writes_outside_its_directory) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put_bytes(std::as_bytes(std::span("GRNBND1\n", 8)));
  const auto entry = [&](std::string_view name) {
    writer.put_text(name);
    writer.put(std::uint64_t{0});
    writer.put(xxh3({}));
  };
  entry("checkpoint");
  entry("segment-/../../escaped");
  std::ofstream(bundle, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  EXPECT_THROW(unpack_run(real_file_system(), bundle, to), StorageError);
  EXPECT_FALSE(std::filesystem::exists(directory / "escaped"));
}

TEST_F(RunBundle, of_a_run_without_checkpoint_is_refused_as_missing) {
  try {
    pack_run(real_file_system(), directory.path(), bundle);
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_EQ(error.fault(), StorageFault::missing);
  }
}

}  // namespace
}  // namespace granary::storage
