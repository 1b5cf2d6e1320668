#include "worker/storage/file_system.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "tests/support/faulty_file_system.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/checksum.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using testing::FaultyFileSystem;
using testing::TemporaryDirectory;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

std::string content_of(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(WriteAtomically, leaves_the_old_content_or_the_new_after_a_fault_at_any_operation) {
  for (const auto fault :
       {FaultyFileSystem::Fault::disk_full, FaultyFileSystem::Fault::power_cut}) {
    for (const bool lose : {false, true}) {
      for (std::uint64_t at = 0;; ++at) {
        TemporaryDirectory directory;
        const Path path = directory.path() / "run" / "file";
        real_file_system().create_directory(path.parent_path());
        write_atomically(real_file_system(), path, bytes_of("old"));
        FaultyFileSystem files(fault, at, directory / "scratch");
        bool failed = false;
        try {
          write_atomically(files, path, bytes_of("brand new"));
        } catch (const StorageError&) {
          failed = true;
        }
        if (lose) files.lose_unsynced(path.parent_path());
        const std::string content = content_of(path);
        if (!files.struck()) {
          EXPECT_GE(at, 5u);  // create, append, sync, rename, sync directory
          EXPECT_EQ(content, "brand new");
          break;
        }
        EXPECT_TRUE(failed);
        EXPECT_TRUE(content == "old" || content == "brand new") << "at " << at << ": " << content;
      }
    }
  }
}

TEST(FileSystem, tells_a_full_disk_from_a_missing_file) {
  TemporaryDirectory directory;
  try {
    real_file_system().open(directory / "absent");
    FAIL() << "opened a file that is not there";
  } catch (const StorageError& error) {
    EXPECT_EQ(error.fault(), StorageFault::missing);
  }
  try {
    real_file_system().create("/dev/full")->append(bytes_of("x"));
    FAIL() << "wrote to a full device";
  } catch (const StorageError& error) {
    EXPECT_EQ(error.fault(), StorageFault::disk_full);
  }
}

TEST(Checksum, sha256_is_the_standard_one) {
  TemporaryDirectory directory;
  std::ofstream(directory / "abc") << "abc";
  const FileDigest digest = sha256_of(real_file_system(), directory / "abc");
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(digest.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest.size_bytes, 3u);
}

}  // namespace
}  // namespace granary::storage
