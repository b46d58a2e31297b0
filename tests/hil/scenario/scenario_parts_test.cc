// Scenarios of several files and templates: the combination is the same model, mistakes refer to their file, no file
// outside the scenario's folder is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "kernel/compile/model_hash.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::scenario_parts_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::uint64_t hash_of(const hil::Scenario& s) {
  PlanOptions options;
  options.dt = s.dt;
  return calc_model_hash(s.model, options);
}

std::string split_scenario(const std::string& include) {
  const std::string good = kGoodScenario;
  return replaced(good.substr(0, good.find("channels:")) + good.substr(good.find("joints:")),
                  "step:", include + "step:");
}
const char* const kChannels = "unlatch_part: 1\nchannels:\n  throttle: {initial: 1, range: [0, 1], safe: 0}\n";

class Includes : public ::testing::Test {
 protected:
  Includes() { fs::create_directories(folder_ / "parts"); }
  ~Includes() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string errors(const std::string& main, const std::vector<std::string>& overrides = {}) const {
    try {
      hil::load_scenario((folder_ / main).string(), overrides);
      return "";
    } catch (const hil::ScenarioError& e) {
      return e.what();
    }
  }

  const fs::path folder_ = fs::temp_directory_path() / ("unlatch_includes_" + std::to_string(getpid()));
};

TEST_F(Includes, GiveTheSameModelAsOneFile) {
  write("parts/channels.yaml", kChannels);
  const auto whole = hil::load_scenario_text(kGoodScenario, "s.yaml");
  const auto split = hil::load_scenario(write("s.yaml", split_scenario("include: parts/channels.yaml\n")));
  EXPECT_EQ(hash_of(split), hash_of(whole));
}

TEST_F(Includes, ARecordingHoldsThemAll) {
  write("parts/inner.yaml", kChannels);
  write("parts/outer.yaml", "unlatch_part: 1\ninclude: inner.yaml");
  const auto first = hil::load_scenario(write("s.yaml", split_scenario("include: [parts/outer.yaml]\n")));
  fs::remove_all(folder_ / "parts");
  EXPECT_EQ(hash_of(hil::load_scenario_text(first.text, "elsewhere.yaml")), hash_of(first));
  EXPECT_EQ(hil::load_scenario_text(first.text, "elsewhere.yaml").text, first.text);
  EXPECT_EQ(hash_of(hil::load_scenario(write("again.yaml", first.text))), hash_of(first));
}

TEST_F(Includes, MistakesPointAtTheirFile) {
  write("parts/channels.yaml", replaced(kChannels, "initial", "inital"));
  write("s.yaml", replaced(split_scenario("include: parts/channels.yaml\n"), "mass: 100", "mass: 0"));
  const std::string text = errors("s.yaml");
  EXPECT_THAT(text, HasSubstr("s.yaml:7:11: body 'core': its mass is 0 kg"));
  EXPECT_THAT(
      text, HasSubstr("parts/channels.yaml:3:14: unknown key 'inital' in channel 'throttle'; did you mean 'initial'"));
}

TEST_F(Includes, BrokenYamlPointsAtItsFile) {
  write("parts/channels.yaml", "unlatch_part: 1\nchannels: {a\n");
  write("s.yaml", split_scenario("include: parts/channels.yaml\n"));
  EXPECT_THAT(errors("s.yaml"), HasSubstr("parts/channels.yaml:3:"));
}

TEST_F(Includes, EntriesOfOneNameInTwoFilesAreAMistake) {
  write("parts/channels.yaml", kChannels);
  write("s.yaml", replaced(split_scenario("include: parts/channels.yaml\n"),
                           "joints:", "channels: {throttle: {initial: 0}}\njoints:"));
  EXPECT_THAT(errors("s.yaml"),
              AllOf(HasSubstr("s.yaml:16:12: duplicate key 'throttle'"),
                    HasSubstr("first given in " + (folder_ / "parts/channels.yaml").string() + " on line 3")));
}

TEST_F(Includes, ATemplateOfOneNameInTwoFilesIsAMistake) {
  write("parts/channels.yaml", "unlatch_part: 1\ntemplates: {leg: {parameters: {i}}}\n");
  write("s.yaml", split_scenario("include: parts/channels.yaml\ntemplates: {leg: {parameters: {i, k}}}\n"));
  EXPECT_THAT(errors("s.yaml"), HasSubstr("duplicate key 'leg'"));
}

TEST_F(Includes, StayInTheFolder) {
  const std::string outside = (folder_ / "../unlatch_outside.yaml").lexically_normal().string();
  std::ofstream(outside) << kChannels;
  fs::create_symlink(outside, folder_ / "link.yaml");
  fs::create_directory(folder_ / "inner");
  const struct {
    std::string include, says;
  } cases[] = {
      {outside, "an absolute path"},
      {"/etc/passwd", "an absolute path"},
      {"../unlatch_outside.yaml", "outside the scenario's folder"},
      {"parts/../../unlatch_outside.yaml", "outside the scenario's folder"},
      {"link.yaml", "outside the scenario's folder"},
      {"nowhere.yaml", "no such file"},
      {"parts", "this is a folder"},
      {".", "folder"},
      {"\"a\\nb\"", "not the name of a file"},
      {"''", "not the name of a file"},
      {"{a: 1}", "names no file"},
  };
  for (const auto& c : cases) {
    write("s.yaml", split_scenario("include: " + c.include + "\n"));
    EXPECT_THAT(errors("s.yaml"), AllOf(HasSubstr("s.yaml:3:10: "), HasSubstr(c.says))) << c.include;
  }
  fs::remove(outside);
}

TEST_F(Includes, AreBounded) {
  write("s.yaml", split_scenario("include: parts/a.yaml\n"));
  write("parts/a.yaml", "unlatch_part: 1\ninclude: b.yaml\n");
  write("parts/b.yaml", "unlatch_part: 1\ninclude: a.yaml\n");
  EXPECT_THAT(errors("s.yaml"), HasSubstr("parts/b.yaml:2:10: cannot include 'a.yaml': it would include itself"));
  fs::create_symlink("a.yaml", folder_ / "parts/c.yaml");  // the same file by another name
  write("parts/b.yaml", "unlatch_part: 1\ninclude: c.yaml\n");
  EXPECT_THAT(errors("s.yaml"), HasSubstr("it would include itself"));
  for (int i = 0; i < 10; ++i)
    write("parts/" + std::to_string(i) + ".yaml", "unlatch_part: 1\ninclude: " + std::to_string(i + 1) + ".yaml\n");
  write("s.yaml", split_scenario("include: parts/0.yaml\n"));
  EXPECT_THAT(errors("s.yaml"), HasSubstr("parts/6.yaml:2:10: cannot include '7.yaml': more than 8 files deep"));
  write("parts/0.yaml", "unlatch_part: 1\n" + std::string((1u << 20) - 100, '#'));
  EXPECT_THAT(errors("s.yaml"), HasSubstr("more than 1 MiB"));
}

TEST_F(Includes, OnceIsEnough) {
  write("parts/channels.yaml", kChannels);
  write("parts/other.yaml", "unlatch_part: 1\ninclude: channels.yaml\n");
  write("s.yaml", split_scenario("include: [parts/channels.yaml, parts/other.yaml]\n"));
  EXPECT_EQ(errors("s.yaml"), "");
}

TEST_F(Includes, AVariantIsItsBaseAndWhatItReplaces) {
  write("s.yaml", kGoodScenario);
  const auto variant = hil::load_scenario(
      write("v.yaml",
            "unlatch: 1\ninclude: s.yaml\nname: variant\nset: {bodies.core.mass: 98, events.contact.delay: 1 ms}\n"));
  EXPECT_EQ(variant.name, "variant");
  EXPECT_EQ(variant.model.bodies[0].mass, 98);
  EXPECT_EQ(variant.model.events[0].delay, 0.001);
  EXPECT_EQ(hil::load_scenario((folder_ / "v.yaml").string(), {"bodies.core.mass=97"}).model.bodies[0].mass, 97);
  write("v.yaml", "unlatch: 1\ninclude: s.yaml\nset: {bodies.core.mas: 98, events.lift.delay: 1}\n");
  EXPECT_THAT(errors("v.yaml"),
              AllOf(HasSubstr("v.yaml:3:7: unknown key 'mas'"), HasSubstr("v.yaml:3:28: no entry 'lift'")));
}

TEST_F(Includes, PartsAreNoScenarios) {
  write("p.yaml", kChannels);
  EXPECT_THAT(errors("p.yaml"), HasSubstr("p.yaml:1:15: this file is a part of scenarios"));
  write("p.yaml", "channels: {}\n");
  write("s.yaml", split_scenario("include: p.yaml\n"));
  EXPECT_THAT(errors("s.yaml"), HasSubstr("p.yaml:1:1: missing header; add `unlatch_part: 1`"));
  write("p.yaml", "unlatch_part: 2\n");
  EXPECT_THAT(errors("s.yaml"), HasSubstr("p.yaml:1:15: another version of the language"));
}

TEST(ScenarioText, IncludesNothingFromTheDisk) {
  EXPECT_THAT(load_errors("unlatch: 1\ninclude: CMakeLists.txt\n"), HasSubstr("does not hold that file"));
}

// --- Templates ------------------------------------------------------------------------------------------------------

const char* const kPlain = R"(unlatch: 1
name: star
step: {dt: 0.001, until: 1}
bodies:
  core: {mass: 100, inertia: [10, 20, 25]}
  arm1: {mass: 2, inertia: [1, 1, 1], position: [1.5, 0, 0]}
  arm2: {mass: 3, inertia: [1, 1, 1], position: [-1.5, 0, 0]}
joints:
  hinge1: {between: [core, arm1], point: [1.5, 0, 0], modes: {hinge: {kind: weld}, free: {rows: []}}, mode: hinge}
  hinge2: {between: [core, arm2], point: [-1.5, 0, 0], modes: {hinge: {kind: weld}, free: {rows: []}}, mode: hinge}
events:
  - {name: drop, subject: arm1, when: {time: 0.5}, then: [{set_mode: {joint: hinge1, mode: free}}]}
  - {name: drop, subject: arm2, when: {time: 0.5}, then: [{set_mode: {joint: hinge2, mode: free}}]}
)";
const char* const kTemplated = R"(unlatch: 1
name: star
step: {dt: 0.001, until: 1}
bodies:
  core: {mass: 100, inertia: [10, 20, 25]}
templates:
  arm:
    parameters: {i, side, mass: <i> + 1, at: 0.5 s}
    bodies:
      arm<i>: {mass: <mass>, inertia: [1, 1, 1], position: <side>}
    joints:
      hinge<i>: {between: [core, arm<i>], point: <side>, modes: {hinge: {kind: weld}, free: {rows: []}}, mode: hinge}
    events:
      - {name: drop, subject: arm<i>, when: {time: 2 * <at> / 2}, then: [{set_mode: {joint: hinge<i>, mode: free}}]}
instances:
  - {template: arm, for: [{i: 1, side: [1.5, 0, 0]}, {i: 2, side: [-1.5, 0, 0]}]}
)";

TEST(Templates, MakeTheSameModel) {
  EXPECT_EQ(hash_of(hil::load_scenario_text(kTemplated, "t.yaml")), hash_of(hil::load_scenario_text(kPlain, "p.yaml")));
  const std::string counted =
      replaced(replaced(kTemplated, "for: [{i: 1, side: [1.5, 0, 0]}, {i: 2, side: [-1.5, 0, 0]}]", "count: 2"),
               "{i, side, mass", "{i, side: [1.5*(3 - 2*<i>), 0, 0], mass");
  EXPECT_EQ(hash_of(hil::load_scenario_text(counted, "t.yaml")), hash_of(hil::load_scenario_text(kPlain, "p.yaml")));
}

TEST(Templates, OverridesReachWhatTheyMake) {
  const auto s =
      hil::load_scenario_text(kTemplated, "t.yaml", {"bodies.arm2.mass=7", "events.drop:arm1.enabled=false"});
  EXPECT_EQ(s.model.bodies[1].mass, 2);
  EXPECT_EQ(s.model.bodies[2].mass, 7);
  EXPECT_EQ(s.model.events.size(), 1u);
  EXPECT_THAT(load_errors(kTemplated, {"templates.arm.bodies=1"}), HasSubstr("worked out before"));
}

std::string template_errors(const std::string& what, const std::string& with) {
  return load_errors(replaced(kTemplated, what, with));
}

TEST(Templates, AMistakeIsReportedOnceWithItsInstance) {
  const std::string text = template_errors("inertia: [1, 1, 1], position", "inertia: [1, 1, 1], positon");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 0) << text;
  EXPECT_THAT(text,
              AllOf(HasSubstr("s.yaml:10:50: unknown key 'positon'"),
                    HasSubstr("(arm: i 1, mass 1 + 1, at 0.5 s, and 1 more)"), HasSubstr("did you mean 'position'")));
}

TEST(Templates, MistakesOfParametersAreAtTheRow) {
  EXPECT_THAT(template_errors("{i: 2, side", "{i: 2, sid"),
              AllOf(HasSubstr("no parameter 'sid'"), HasSubstr("did you mean 'side'")));
  EXPECT_THAT(template_errors("{i: 2, side: [-1.5, 0, 0]}", "{i: 2}"), HasSubstr("parameter 'side' has no value"));
  EXPECT_THAT(template_errors("template: arm", "template: arn"), HasSubstr("did you mean 'arm'"));
  EXPECT_THAT(template_errors("arm<i>: {mass", "arm<j>: {mass"),
              AllOf(HasSubstr("s.yaml:10:7: no parameter 'j'"), HasSubstr("known: i")));
  EXPECT_THAT(template_errors("time: 2 * <at> / 2", "time: 2 * <side>"), HasSubstr("parameter 'side' is a list"));
  EXPECT_THAT(template_errors("{i: 2, side: [-1.5, 0, 0]}", "{i: 2, side: [-1.5, 0]}"), HasSubstr("3 numbers"));
  EXPECT_THAT(template_errors("    parameters", "    colour: red\n    parameters"),
              HasSubstr("unknown key 'colour' in template 'arm'"));
  EXPECT_THAT(template_errors("for: [", "count: 2, for: ["), HasSubstr("both"));
  EXPECT_THAT(template_errors("for: [{i: 1, side: [1.5, 0, 0]}, {i: 2, side: [-1.5, 0, 0]}]", "count: 1e9"),
              HasSubstr("1 to 1000"));
}

// Parameters of parameters could double at each step.
TEST(Templates, AreBounded) {
  const std::string one_to_thousand =
      replaced(replaced(kTemplated, "for: [{i: 1, side: [1.5, 0, 0]}, {i: 2, side: [-1.5, 0, 0]}]", "count: 1000"),
               "{i, side, mass", "{i, side: [1.5, 0, 0], mass");
  std::string big = "[1";
  for (int i = 0; i < 300; ++i) big += ", 1";
  EXPECT_THAT(load_errors(replaced(one_to_thousand, "inertia: [1, 1, 1]", "inertia: " + big + "]")),
              HasSubstr("more than 200,000 values"));
  std::string texts = ", p0: abcdefgh", lists = ", p0: [1, 1]", deep = ", p0: [1]";
  for (int i = 1; i < 60; ++i) {
    const std::string name = ", p" + std::to_string(i) + ": ", last = "<p" + std::to_string(i - 1) + ">";
    texts += name + last + last;
    lists += name + "[" + last + ", " + last + "]";
    deep += name + "[" + last + "]";
  }
  const auto with = [](const std::string& parameters) {
    return load_errors(replaced(kTemplated, "at: 0.5 s}", "at: 0.5 s" + parameters + "}"));
  };
  EXPECT_THAT(with(texts), HasSubstr("a text of more than 1024 bytes"));
  EXPECT_THAT(with(lists), HasSubstr("more than 200,000 values"));
  EXPECT_THAT(with(deep), HasSubstr("32 levels"));
}

// The templates give the same as the four boosters written in full, to the last bit.
TEST(Templates, TheBoostersAreTheSameFour) {
  const std::string plain = UNLATCH_SOURCE_DIR "/tests/data/boosters-plain.yaml";
  const auto made = hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/scenario.yaml");
  EXPECT_EQ(hash_of(made), hash_of(hil::load_scenario(plain)));
  const auto dead = hil::load_scenario(UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/dead-nozzle.yaml");
  EXPECT_EQ(hash_of(dead), hash_of(hil::load_scenario(plain, {"events.contact:booster1.enabled=false"})));
  EXPECT_NE(hash_of(dead), hash_of(made));
  EXPECT_EQ(dead.name, "boosters-dead-nozzle");
}

}  // namespace
}  // namespace unlatch::test::scenario_parts_test
