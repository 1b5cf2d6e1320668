#include "client/commands/submission.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>

#include "client/commands/duration.h"
#include "proto/contract/scene_meshes.h"
#include "proto/contract/scene_text.h"

namespace granary::commands {
namespace {

Error scene_error(const std::string& source, const std::string& what) {
  return {ErrorCode::invalid_argument, source + ": " + what, ""};
}

std::string too_large(const std::string& size) {
  return size + ", a scene has at most " + std::to_string(kMaxSceneBytes) + " bytes";
}

// Closes what it opened; standard input stays open.
class InputFile {
 public:
  explicit InputFile(const std::string& path)
      : fd_(path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~InputFile() {
    if (fd_ > STDIN_FILENO) close(fd_);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

Result<std::string> read_scene(const std::string& path, const std::string& source) {
  const InputFile file(path);
  struct stat facts {};
  if (file.fd() < 0 || fstat(file.fd(), &facts) != 0)
    return scene_error(source, std::strerror(errno));
  if (S_ISDIR(facts.st_mode)) return scene_error(source, "is a directory");
  if (S_ISREG(facts.st_mode) && facts.st_size > static_cast<off_t>(kMaxSceneBytes))
    return scene_error(source, too_large(std::to_string(facts.st_size) + " bytes"));
  std::string text;
  std::vector<char> block(1 << 16);
  for (;;) {
    const ssize_t got = read(file.fd(), block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return scene_error(source, std::strerror(errno));
    if (got == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
    if (text.size() > kMaxSceneBytes) return scene_error(source, too_large("more than that"));
  }
}

// "path=value" at the first '='.
Result<FieldSetting> split_pair(const std::string& text, const char* option) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return Error{ErrorCode::invalid_argument,
                 std::string(option) + " '" + text + "' is not of the form name=value", ""};
  return FieldSetting{text.substr(0, equals), text.substr(equals + 1)};
}

Result<std::vector<FieldSetting>> split_pairs(const std::vector<std::string>& texts,
                                              const char* option) {
  std::vector<FieldSetting> pairs;
  for (const std::string& text : texts) {
    auto pair = split_pair(text, option);
    if (!pair) return pair.error();
    pairs.push_back(*pair);
  }
  return pairs;
}

// Errors of resolve() know the field; the line comes from the text.
Error with_line(const Error& error, const std::string& text, const std::string& source) {
  std::string where = source;
  if (const auto parsed = parse_scene(text, source)) {
    const auto line = parsed->line_of.find(error.field_path);
    if (line != parsed->line_of.end()) where += ":" + std::to_string(line->second);
  }
  return {error.code, where + ": " + error.message, error.field_path};
}

Result<LoadedScene> load_one(const std::string& path, const std::vector<FieldSetting>& settings) {
  const std::string source = path == "-" ? "<stdin>" : path;
  auto text = read_scene(path, source);
  if (!text) return text.error();
  auto scene = load_scene(*text, source, settings);
  if (!scene) return scene.error();
  if (const Status status = inline_meshes(*scene, path); !status)
    return with_line(status.error(), *text, source);
  auto resolved = resolve(*scene);
  if (!resolved) return with_line(resolved.error(), *text, source);
  return LoadedScene{source, std::move(*scene), std::move(*resolved)};
}

}  // namespace

Result<std::string> read_input(const std::string& path) {
  return read_scene(path, path == "-" ? "<stdin>" : path);
}

void add_scene_options(CLI::App& verb, SubmissionOptions& options, bool many) {
  auto* scenes =
      verb.add_option("SCENE", options.scenes, "scene file, protobuf text or JSON; - reads stdin");
  scenes->required()->type_name("");
  if (!many) scenes->expected(1);
  verb.add_option("--set", options.settings, "set a scene field: path=value (repeatable)")
      ->allow_extra_args(false)
      ->type_name("PATH=VALUE");
}

void add_submission_options(CLI::App& verb, SubmissionOptions& options) {
  verb.add_option("--tag", options.tags, "label the jobs: name=value (repeatable)")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  verb.add_option("--worker-tag", options.worker_tags,
                  "only workers started with this --tag: name=value (repeatable)")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  verb.add_option("--priority", options.priority, "higher runs first (default 0)");
  verb.add_option("--request-id", options.request_id,
                  "the same id again returns the same jobs, whatever happened in between");
  verb.add_flag("--fresh", options.fresh, "compute anew: no stored result, no stored filling");
  verb.add_option("--time-limit", options.time_limit, "stop after this long: 90, 90s, 10m, 2h")
      ->type_name("DURATION");
}

Result<std::vector<LoadedScene>> load_scenes(const SubmissionOptions& options) {
  auto settings = split_pairs(options.settings, "--set");
  if (!settings) return settings.error();
  if (std::count(options.scenes.begin(), options.scenes.end(), "-") > 1)
    return Error{ErrorCode::invalid_argument, "- (stdin) can be read once only", ""};
  std::vector<LoadedScene> loaded;
  for (const std::string& path : options.scenes) {
    auto scene = load_one(path, *settings);
    if (!scene) return scene.error();
    loaded.push_back(std::move(*scene));
  }
  return loaded;
}

Result<v1::SubmitJobsRequest> make_request(const SubmissionOptions& options,
                                           std::uint32_t default_threads) {
  auto tags = split_pairs(options.tags, "--tag");
  if (!tags) return tags.error();
  auto worker_tags = split_pairs(options.worker_tags, "--worker-tag");
  if (!worker_tags) return worker_tags.error();
  double time_limit_s = 0;
  if (!options.time_limit.empty()) {
    auto parsed = parse_duration_s(options.time_limit);
    if (!parsed)
      return Error{ErrorCode::invalid_argument, "--time-limit " + parsed.error().message, ""};
    time_limit_s = *parsed;
  }
  auto loaded = load_scenes(options);
  if (!loaded) return loaded.error();
  v1::SubmitJobsRequest request;
  request.set_request_id(options.request_id);
  for (LoadedScene& scene : *loaded) {
    auto& item = *request.add_items();
    *item.mutable_scene() = std::move(scene.scene);
    if (default_threads > 0 && !item.scene().has_threads())
      item.mutable_scene()->set_threads(default_threads);
    for (const auto& [name, value] : *tags) (*item.mutable_tags())[name] = value;
    for (const auto& [name, value] : *worker_tags) (*item.mutable_worker_tags())[name] = value;
    item.set_priority(options.priority);
    item.set_time_limit_s(time_limit_s);
    item.set_fresh(options.fresh);
  }
  return request;
}

Result<std::vector<std::string>> submit_scenes(Context& context, const SubmissionOptions& options) {
  auto settings = context.settings();
  if (!settings) return settings.error();
  const int threads = std::atoi((*settings)[session::SettingKey::threads].value.c_str());
  auto request = make_request(options, static_cast<std::uint32_t>(threads));
  if (!request) return request.error();
  auto session = context.session();
  if (!session) return session.error();
  return (*session)->submit(std::move(*request));
}

}  // namespace granary::commands
