// Words that the kernel has for people.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "unlatch/plan.h"
#include "unlatch/plan_image.h"
#include "unlatch/quantities.h"
#include "unlatch/step.h"

namespace unlatch::test {
namespace {

// Texts of the values 0 … last of an enumeration.
template <class Status>
std::multiset<std::string> list_texts(Status last) {
  std::multiset<std::string> texts;
  for (int i = 0; i <= static_cast<int>(last); ++i) texts.insert(get_status_text(static_cast<Status>(i)));
  return texts;
}

TEST(Texts, EachStatusHasOneOfItsOwn) {
  for (const std::multiset<std::string>& texts :
       {list_texts(StepStatus::kRigidContact), list_texts(ImageStatus::kRange)}) {
    for (const std::string& text : texts) {
      EXPECT_FALSE(text.empty());
      EXPECT_EQ(texts.count(text), 1u) << text;
    }
  }
}

TEST(Texts, EachInstructionSetHasItsName) {
  EXPECT_STREQ(get_name(InstructionSet::kScalar), "scalar");
  EXPECT_STREQ(get_name(InstructionSet::k256), "avx2");
  EXPECT_STREQ(get_name(InstructionSet::k512), "avx512");
  const std::string two = get_name(InstructionSet::k128);
  EXPECT_TRUE(two == "sse2" || two == "neon") << two;
  EXPECT_STRNE(get_name(InstructionSet::kAuto), "");
}

TEST(Texts, ComponentsHaveTheNamesOfTheirAxes) {
  const auto list = [](Quantity::Kind kind) {
    std::string names;
    for (int i = 0; i < 3; ++i) names += get_component_name(get_traits(kind), i) + std::string(" ");
    return names;
  };
  EXPECT_EQ(list(Quantity::Kind::kPosition), "x y z ");
  EXPECT_EQ(list(Quantity::Kind::kSurfaceVelocity), "north east down ");
  EXPECT_EQ(list(Quantity::Kind::kOrbitPosition), "radial along across ");
  EXPECT_EQ(list(Quantity::Kind::kOrbitVelocity), "radial along across ");
  EXPECT_EQ(list(Quantity::Kind::kEulerAngles), "roll pitch yaw ");
}

}  // namespace
}  // namespace unlatch::test
