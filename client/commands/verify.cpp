// granary verify: is a result file what was stored? Checks the HDF5 signature and the SHA-256 that
// fetch wrote beside the file, or the one given.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "client/commands/catalogue.h"
#include "client/session/file_checksum.h"

namespace granary::commands {
namespace {

namespace fs = std::filesystem;

Error verification_error(const std::string& what) { return {ErrorCode::data_loss, what, ""}; }

// The format's first eight bytes (HDF5 File Format Specification, superblock).
Status check_signature(const fs::path& file) {
  constexpr std::array<char, 8> kSignature{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::array<char, 8> start{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream || fs::is_directory(file))
    return Error{ErrorCode::not_found, file.string() + " cannot be opened", ""};
  stream.read(start.data(), start.size());
  if (stream.gcount() == static_cast<std::streamsize>(start.size()) && start == kSignature)
    return Done{};
  return verification_error(file.string() + " is not an HDF5 file");
}

// First word of FILE.sha256; empty when there is no such file.
std::string recorded_sum(const fs::path& file) {
  std::ifstream sums(file.string() + ".sha256");
  std::string sum;
  sums >> sum;
  return sum;
}

Outcome verify(Context& context, const std::string& file, const std::string& given) {
  if (auto hdf5 = check_signature(file); !hdf5) return hdf5.error();
  const std::string recorded = given.empty() ? recorded_sum(file) : given;
  if (recorded.empty())
    return verification_error(file + ": no checksum is recorded (" + file +
                              ".sha256, or --sha256 SUM)");
  auto sum = session::sha256_of_file(file);
  if (!sum) return sum.error();
  if (*sum != recorded)
    return verification_error(file + " has SHA-256 " + *sum + ", recorded is " + recorded);
  const render::Table table{{"file", "state", "sha256"}, {{file, "verified", *sum}}};
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_verify(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  auto sum = std::make_shared<std::string>();
  CLI::App& verb = line.verb("verify", "Check a result file against its recorded SHA-256",
                             "granary verify bucket.h5");
  verb.add_option("FILE", *file, "result file")->required()->type_name("");
  verb.add_option("--sha256", *sum, "expected sum (default: the one in FILE.sha256)");
  line.on(verb, [file, sum](Context& context) { return verify(context, *file, *sum); });
}

}  // namespace granary::commands
