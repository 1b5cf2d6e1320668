// granary verify: is a result file what was stored? Checks the HDF5 signature, the SHA-256 that
// fetch wrote beside the file (or the one given), and every dataset's own checksum.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>

#include "client/commands/catalogue.h"
#include "client/session/child_process.h"
#include "client/session/file_checksum.h"

namespace granary::commands {
namespace {

namespace fs = std::filesystem;

Error verification_error(const std::string& what) {
  return {ErrorCode::data_loss, what, ""};
}

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

// The worker program beside this one knows the inside of the file: every dataset has its checksum.
// Its findings go to stderr. Nothing when the client is installed alone.
std::optional<Outcome> verify_inside(const std::string& file) {
  const fs::path worker = session::program_directory() / "granary-worker";
  if (!fs::exists(worker)) return std::nullopt;
  auto code = session::run_child(
      {.command = {worker, "--verify", file}, .log_file = {}, .output_to_stderr = true});
  if (!code) return Outcome(code.error());
  if (*code == 0) return Outcome(ExitCode::ok);
  return Outcome(verification_error(file + " is damaged inside"));
}

Status compare_sum(const std::string& file, const std::string& recorded) {
  auto sum = session::sha256_of_file(file);
  if (!sum) return sum.error();
  if (*sum == recorded) return Done{};
  return verification_error(file + " has SHA-256 " + *sum + ", recorded is " + recorded);
}

Outcome verify(Context& context, const std::string& file, const std::string& given) {
  if (auto hdf5 = check_signature(file); !hdf5) return hdf5.error();
  const std::string recorded = given.empty() ? recorded_sum(file) : given;
  if (!recorded.empty())
    if (auto same = compare_sum(file, recorded); !same) return same.error();
  const auto inside = verify_inside(file);
  if (inside && !*inside) return *inside;
  if (!inside && recorded.empty())
    return verification_error(file + ": nothing to check it against (" + file +
                              ".sha256, --sha256 SUM, or granary-worker beside granary)");
  const render::Table table{
      {"file", "state", "sha256", "datasets"},
      {{file, "verified", recorded.empty() ? render::Json(nullptr) : render::Json(recorded),
        inside ? "intact" : "not checked"}}};
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_verify(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  auto sum = std::make_shared<std::string>();
  CLI::App& verb = line.verb("verify", "Check a result file: recorded SHA-256, every dataset",
                             "granary verify bucket.h5");
  verb.add_option("FILE", *file, "result file")->required()->type_name("");
  verb.add_option("--sha256", *sum, "expected sum (default: the one in FILE.sha256)");
  line.on(verb, [file, sum](Context& context) { return verify(context, *file, *sum); });
}

}  // namespace granary::commands
