// Hostile texts: each is refused with a place, quickly, and without other effects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "hil/scenario/yaml/yaml_document.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::scenario_hostile_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string with_title(const std::string& title) {
  return replaced(kGoodScenario, "name: pair", "name: pair\ntitle: " + title);
}

TEST(ScenarioText, IsPlainUtf8) {
  EXPECT_EQ(load_errors(with_title("Отделение ускорителей 🚀")), "");
  EXPECT_THAT(load_errors(with_title(std::string("a\0b", 3))), StartsWith("s.yaml:3:9: a control byte"));
  EXPECT_THAT(load_errors(with_title("a\x1b[31m")), StartsWith("s.yaml:3:9: a control byte"));
  for (const char* bytes : {"\xff", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80"})
    EXPECT_THAT(load_errors(with_title(bytes)), StartsWith("s.yaml:3:8: a byte that is not UTF-8"));
}

TEST(ScenarioText, HasNoAnchorsAliasesOrTags) {
  EXPECT_THAT(load_errors(with_title("&a [*a]")), HasSubstr("an anchor or alias"));
  EXPECT_THAT(load_errors("a: &a [x, x]\nb: [*a, *a]\n"), HasSubstr("s.yaml:1:"));
  EXPECT_THAT(load_errors(with_title("!!binary aGk=")), HasSubstr("the tag"));
}

TEST(ScenarioText, IsBounded) {
  EXPECT_THAT(load_errors(std::string((1u << 20) + 1, ' ')), HasSubstr("at most 1 MiB"));
  EXPECT_THAT(load_errors(with_title(std::string(40, '[') + std::string(40, ']'))), HasSubstr("32 levels"));
  EXPECT_THAT(load_errors(with_title(std::string(100'000, '[') + std::string(100'000, ']'))), HasSubstr("32 levels"));
  EXPECT_NE(load_errors(with_title(std::string(100'000, '{'))), "");
  std::string many = "[";
  for (int i = 0; i < 250'000; ++i) many += "1,";
  EXPECT_THAT(load_errors(with_title(many + "1]")), HasSubstr("200,000 values"));
}

TEST(ScenarioText, IsOneDocumentThatIsAMapping) {
  EXPECT_THAT(load_errors(std::string(kGoodScenario) + "---\na: 1\n"), HasSubstr("a second document"));
  EXPECT_THAT(load_errors(""), HasSubstr("there is nothing in it"));
  EXPECT_THAT(load_errors("[1, 2]"), StartsWith("s.yaml:1:1: "));
  EXPECT_THAT(load_errors("? [a]\n: 1\n"), HasSubstr("a key that is not a name"));
  EXPECT_THAT(load_errors("a: b: c\n"), HasSubstr("not YAML"));
}

// For any changed bytes the loader returns a scenario or a ScenarioError.
TEST(ScenarioText, SurvivesRandomDamage) {
  constexpr unsigned kSeed = 20'260;
  std::mt19937 random(kSeed);
  const std::string good = kGoodScenario;
  const std::string spice = "{}[]:,-&*!#|>'\"%@`\n \t0e.x";
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = good;
    for (unsigned k = random() % 4 + 1; k > 0; --k) {
      const std::size_t at = random() % text.size();
      const char byte = spice[random() % spice.size()];
      if (random() % 3 == 0)
        text.erase(at, random() % 20);
      else if (random() % 2 == 0)
        text.insert(at, 1, byte);
      else
        text[at] = byte;
    }
    refused += load_errors(text).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 1000) << "seed " << kSeed;
}

}  // namespace
}  // namespace unlatch::test::scenario_hostile_test
