// Verbs that need no server, and the command line itself.
#include <nlohmann/json.hpp>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;
using Json = nlohmann::json;

class ClientOffline : public ClientTest {
 protected:
  ClientOffline() { environment_.erase("GRANARY_SERVER"); }
};

TEST_F(ClientOffline, usage_errors_are_exit_2_with_one_line_and_the_nearest_name) {
  for (const auto& [arguments, hint] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{}, "a verb is needed"},
           {{"subit", "x"}, "did you mean 'submit'"},
           {{"ls", "--fromat", "json"}, "did you mean '--format'"},
           {{"ls", "--format", "xml"}, "--format"},
           {{"ls", "--state", "done"}, "--state"},
           {{"run"}, "SCENE"},
           {{"ls", "extra"}, "unexpected 'extra'"},
           {{"scene", "new", "silo"}, "KIND"},
           {{"ls", "--server", "nonsense"}, "unix:PATH or HOST:PORT"}}) {
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 2) << hint;
    EXPECT_THAT(outputs.err, IsOneErrorLine());
    EXPECT_THAT(outputs.err, HasSubstr(hint));
    EXPECT_THAT(outputs.out, IsEmpty());
  }
}

TEST_F(ClientOffline, every_verb_has_help_with_an_example) {
  for (const char* verb :
       {"run",    "up",     "check",  "submit",     "watch",   "status", "ls",
        "cancel", "retry",  "delete", "logs",       "workers", "values", "explain",
        "fetch",  "verify", "health", "completion", "export",  "scene",  "config"}) {
    const Outputs outputs = granary({verb, "--help"});
    EXPECT_EQ(outputs.exit_code, 0) << verb;
    EXPECT_THAT(outputs.out, HasSubstr(std::string("Example:\n  ")));
    EXPECT_THAT(outputs.out, HasSubstr(verb));
    EXPECT_THAT(outputs.err, IsEmpty());
  }
  EXPECT_THAT(granary({"--version"}).out, StartsWith("granary "));
}

TEST_F(ClientOffline, config_show_says_where_each_value_comes_from) {
  environment_["GRANARY_DATA"] = "/srv/g";
  environment_["GRANARY_LOG_LEVEL"] = "warn";
  const Outputs outputs = granary({"config", "show", "--server", "h:1", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  Json by_key;
  for (const Json& row : Json::parse(outputs.out)) by_key[row["key"].get<std::string>()] = row;
  EXPECT_EQ(by_key["server"]["value"], "h:1");
  EXPECT_EQ(by_key["server"]["source"], "option --server");
  EXPECT_EQ(by_key["data"]["source"], "environment GRANARY_DATA");
  EXPECT_EQ(by_key["log_level"]["value"], "warn");
  EXPECT_EQ(by_key["token_file"]["source"], "default");
}

TEST_F(ClientOffline, new_scenes_are_valid_and_their_comments_give_ranges) {
  for (const char* kind : {"discharge", "chute"}) {
    const Outputs made = granary({"scene", "new", kind});
    EXPECT_EQ(made.exit_code, 0);
    EXPECT_THAT(made.out, HasSubstr("; > 0 and <= "));
    EXPECT_THAT(made.out, HasSubstr("; required"));
    const Outputs checked = granary({"check", "-", "--format", "json"}, made.out);
    EXPECT_EQ(checked.exit_code, 0) << checked.err;
    EXPECT_EQ(Json::parse(checked.out)["kind"], kind);
  }
}

TEST_F(ClientOffline, new_scene_never_replaces_a_file) {
  const std::string file = scratch_.file("new.txtpb");
  EXPECT_EQ(granary({"scene", "new", "chute", "-o", file}).exit_code, 0);
  const std::string before = file_text(file);
  const Outputs again = granary({"scene", "new", "discharge", "-o", file});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, IsOneErrorLine());
  EXPECT_EQ(file_text(file), before);
}

TEST_F(ClientOffline, every_commented_out_field_of_a_new_scene_is_a_real_one) {
  for (const char* kind : {"discharge", "chute"}) {
    std::string text = granary({"scene", "new", kind}).out;
    // Alternatives that exclude each other stay out; all else is switched on.
    std::istringstream lines(text);
    std::string all;
    for (std::string line; std::getline(lines, line);) {
      const auto mark = line.find("# ");
      const bool is_field = mark != std::string::npos && line.find_first_not_of(' ') == mark &&
                            line.find(": ", mark) != std::string::npos &&
                            line.find("; ") != std::string::npos;
      if (is_field && line.find("rademacher_ka") == std::string::npos) line.erase(mark, 2);
      all += line + "\n";
    }
    const Outputs checked = granary({"check", "-"}, all);
    EXPECT_EQ(checked.exit_code, 0) << checked.err << all;
  }
}

TEST_F(ClientOffline, check_prints_effects_with_numbers_and_every_setting_with_who_chose_it) {
  const Outputs outputs =
      granary({"check", scene(), "--format", "json", "--set", "discharge.particles.count=123"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  const Json plan = Json::parse(outputs.out);
  EXPECT_EQ(plan["particles"], 123);
  EXPECT_TRUE(plan["effects"]["gas"]["number"].is_number());
  EXPECT_TRUE(plan["effects"]["gas"]["threshold"].is_number());
  EXPECT_FALSE(plan["effects"]["cohesion"]["on"].get<bool>());
  bool found = false;
  for (const Json& setting : plan["settings"])
    if (setting["path"] == "discharge.time_step_s") {
      found = true;
      EXPECT_EQ(setting["chosen_by"], "auto");
      EXPECT_FALSE(setting["evidence"].get<std::string>().empty());
    }
  EXPECT_TRUE(found);
  EXPECT_THAT(granary({"check", scene()}).out, HasSubstr("valid discharge, 20 particles"));
}

TEST_F(ClientOffline, check_counts_the_grains_that_a_chute_is_fed) {
  // 0.4 kg/s for 0.4 s of 2550 kg/m3 spheres of 3 mm: 0.16 kg / 3.605e-5 kg = 4438.
  const std::string chute = granary({"scene", "new", "chute"}).out;
  const Json plan = Json::parse(granary({"check", "-", "--format", "json"}, chute).out);
  EXPECT_EQ(plan["particles"], 4438);
}

TEST_F(ClientOffline, check_refuses_a_bad_scene_with_2) {
  const Outputs outputs = granary({"check", scene(), "--set", "discharge.particles.count=0"});
  EXPECT_EQ(outputs.exit_code, 2);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
}

TEST_F(ClientOffline, bash_completion_offers_verbs_options_and_values) {
  scratch_.write("completion", granary({"completion", "bash"}).out);
  const auto offers = [&](const std::string& words, int position) {
    const std::string script = "source " + scratch_.file("completion") + "; COMP_WORDS=(" + words +
                               "); COMP_CWORD=" + std::to_string(position) +
                               "; _granary; echo \"${COMPREPLY[@]}\"";
    return run_program({.command = {"/bin/bash", "-c", script}, .environment = {}, .input = ""})
        .out;
  };
  EXPECT_EQ(offers("granary sub", 1), "submit\n");
  EXPECT_EQ(offers("granary submit --ti", 2), "--time-limit\n");
  EXPECT_EQ(offers("granary scene ''", 2).substr(0, 4), "new ");
  EXPECT_EQ(offers("granary ls --format ''", 3), "table json csv\n");
  EXPECT_EQ(offers("granary --server x ls --sta", 4), "--state\n");
  EXPECT_THAT(offers("granary ls --pri", 2), Not(HasSubstr("priority")));
}

TEST_F(ClientOffline, completion_scripts_name_every_verb) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const std::string script = granary({"completion", shell}).out;
    for (const char* verb : {"run", "up", "submit", "watch", "fetch", "completion"})
      EXPECT_THAT(script, HasSubstr(verb)) << shell;
    EXPECT_THAT(script, Not(HasSubstr("--private"))) << shell;
  }
  EXPECT_EQ(granary({"completion", "tcsh"}).exit_code, 2);
}

}  // namespace
}  // namespace granary::test
