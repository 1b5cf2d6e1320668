// granary completion: shell completions, made from the command tree itself.
#include <sstream>
#include <vector>

#include "client/commands/catalogue.h"

namespace granary::commands {
namespace {

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

// Visible options with a long name.
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty() && !option->get_group().empty()) options.push_back(option);
  return options;
}

struct Level {
  std::string path;  // "", "/run", "/scene/new"
  const CLI::App* app;
};

void collect_levels(const CLI::App& app, const std::string& path, std::vector<Level>& levels) {
  levels.push_back({path, &app});
  for (const CLI::App* verb : verbs_of(app))
    collect_levels(*verb, path + "/" + verb->get_name(), levels);
}

// What may follow at a level: its verbs, its options and the common ones.
std::string words_of(const CLI::App& app, const CLI::App& root) {
  std::string words;
  for (const CLI::App* verb : verbs_of(app)) words += verb->get_name() + " ";
  for (const CLI::Option* option : options_of(app)) words += "--" + option->get_lnames()[0] + " ";
  if (&app != &root)
    for (const CLI::Option* option : options_of(root))
      words += "--" + option->get_lnames()[0] + " ";
  words.pop_back();
  return words;
}

// bash and zsh walk the words typed so far along the tree in the same way. Names keep clear of
// zsh's special `path` and `words`.
std::string walk(const CLI::App& root) {
  std::vector<Level> levels;
  collect_levels(root, "", levels);
  std::string nodes;
  std::string answers;
  for (const Level& level : levels) {
    if (!level.path.empty()) nodes += (nodes.empty() ? "" : "|") + level.path;
    answers += "    \"" + level.path + "\") offer=\"" + words_of(*level.app, root) + "\" ;;\n";
  }
  return "    case \"$level/$word\" in\n      " + nodes +
         ") level=\"$level/$word\" ;;\n    esac\n  done\n  case \"$level\" in\n" + answers +
         "  esac\n  case \"$previous\" in\n    --format) offer=\"table json csv\" ;;\n"
         "    --state) offer=\"waiting running complete error unstable cancelled\" ;;\n"
         "    --kind|new) offer=\"discharge chute\" ;;\n"
         "    completion) offer=\"bash zsh fish\" ;;\n  esac\n";
}

std::string bash_script(const CLI::App& root) {
  return "_granary() {\n  local current=\"${COMP_WORDS[COMP_CWORD]}\" level=\"\" word offer=\"\"\n"
         "  local previous=\"${COMP_WORDS[COMP_CWORD-1]}\"\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n" +
         walk(root) +
         "  COMPREPLY=($(compgen -W \"$offer\" -- \"$current\"))\n}\n"
         "complete -o default -F _granary granary\n";
}

std::string zsh_script(const CLI::App& root) {
  return "#compdef granary\n_granary() {\n"
         "  local level=\"\" word offer=\"\" previous=\"${words[CURRENT-1]}\"\n"
         "  for word in \"${(@)words[2,CURRENT-1]}\"; do\n" +
         walk(root) +
         "  compadd -- ${=offer}\n  _files\n}\n"
         "if [ \"$funcstack[1]\" = _granary ]; then _granary \"$@\"; else compdef _granary "
         "granary; "
         "fi\n";
}

std::string single_quoted(const std::string& text) {
  std::string quoted = "'";
  for (char letter : text) {
    if (letter == '\'' || letter == '\\') quoted += '\\';
    quoted += letter;
  }
  return quoted + "'";
}

void append_fish_options(std::ostringstream& text, const CLI::App& app, const std::string& when) {
  for (const CLI::Option* option : options_of(app)) {
    text << "complete -c granary" << when << " -l " << option->get_lnames()[0];
    for (const std::string& name : option->get_snames()) text << " -s " << name;
    if (option->get_items_expected_max() > 0) text << " -r";
    text << " -d " << single_quoted(option->get_description()) << "\n";
  }
}

std::string fish_script(const CLI::App& root) {
  std::ostringstream text;
  append_fish_options(text, root, "");
  std::vector<Level> levels;
  collect_levels(root, "", levels);
  for (const Level& level : levels) {
    const bool is_root = level.path.empty();
    const std::string when =
        is_root ? " -n __fish_use_subcommand"
                : " -n '__fish_seen_subcommand_from " + level.app->get_name() + "'";
    for (const CLI::App* verb : verbs_of(*level.app))
      text << "complete -c granary -f" << when << " -a " << verb->get_name() << " -d "
           << single_quoted(verb->get_description()) << "\n";
    if (!is_root) append_fish_options(text, *level.app, when);
  }
  return text.str();
}

std::string script_for(const std::string& shell, const CLI::App& root) {
  if (shell == "bash") return bash_script(root);
  if (shell == "zsh") return zsh_script(root);
  return fish_script(root);
}

}  // namespace

void add_completion(CommandLine& line) {
  auto shell = std::make_shared<std::string>();
  CLI::App& verb =
      line.verb("completion", "Print shell completions", "source <(granary completion bash)");
  verb.add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}))
      ->type_name("");
  line.on(verb, [shell, &line](Context& context) -> Outcome {
    if (auto written = context.write(script_for(*shell, line.root())); !written)
      return written.error();
    return ExitCode::ok;
  });
}

}  // namespace granary::commands
