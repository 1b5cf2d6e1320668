// granary optimize: a study file (granary.v1.StudySpec) into a queued optimization.
#include "client/commands/catalogue.h"
#include "client/commands/studies.h"
#include "client/commands/study_file.h"

namespace granary::commands {
namespace {

struct OptimizeOptions {
  StudyFileOptions file;
  std::uint32_t budget = 0;
  std::string method;
  std::uint64_t seed = 0;
  std::string request_id;
  bool wait = false;
};

Outcome optimize(Context& context, const OptimizeOptions& options) {
  auto spec = load_study(options.file);
  if (!spec) return spec.error();
  if (!spec->has_optimize())
    return Error{ErrorCode::invalid_argument, options.file.path + ": has no optimize { }",
                 "optimize"};
  if (options.budget > 0) spec->mutable_optimize()->set_budget(options.budget);
  if (options.seed > 0) spec->set_seed(options.seed);
  v1::Optimize::Method method;
  if (!options.method.empty() && v1::Optimize::Method_Parse(options.method, &method))
    spec->mutable_optimize()->set_method(method);
  v1::SubmitStudyRequest request;
  request.set_request_id(options.request_id);
  *request.mutable_spec() = std::move(*spec);
  return submit_study(context, std::move(request), options.wait);
}

}  // namespace

void add_optimize(CommandLine& line) {
  auto options = std::make_shared<OptimizeOptions>();
  CLI::App& verb =
      line.verb("optimize", "Queue an optimization; prints the study's name",
                "granary optimize tests/scenes/studies/wall_small.txtpb --budget 60 --wait");
  add_study_file_options(verb, options->file);
  verb.add_option("--budget", options->budget, "trials in all, instead of the file's");
  verb.add_option("--method", options->method, "instead of the file's")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, std::string>{{"gradual_deformation", "GRADUAL_DEFORMATION"},
                                             {"cma_es", "CMA_ES"},
                                             {"nsga_ii", "NSGA_II"},
                                             {"random_search", "RANDOM_SEARCH"}},
          CLI::ignore_case))
      ->type_name("METHOD");
  verb.add_option("--seed", options->seed, "of the study's random numbers, instead of the file's");
  verb.add_option("--request-id", options->request_id, "the same id again returns the same study");
  verb.add_flag("--wait", options->wait, "until it has ended; prints its trials");
  line.on(verb, [options](Context& context) { return optimize(context, *options); });
}

}  // namespace granary::commands
