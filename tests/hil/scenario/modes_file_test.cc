// The modes file: a written file reads back to the last bit, a damaged one is refused with its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hil/scenario/modes_support.h"

namespace unlatch::test::modes_file_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kGood = R"(unlatch modes 1
# by hand
title Two masses
source nobody's program, version 0
frequencies 2.5 40
marker tip 1 0 0
0 0 1   0 0.5 0
0 0 -1  0 +2e-1 0
points 2
1.5   1 0 0   0 0 1   0 0 -1
0.5  -1 0 0   0 0 3   0 1 0     # the lighter one
end
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("test text has no '" + what + "'");
  return text.replace(at, what.size(), with);
}

std::string get_errors(const std::string& text) {
  try {
    hil::read_modes_text(text, "m.modes");
    return "";
  } catch (const hil::ScenarioError& error) {
    return error.what();
  }
}

TEST(ModesFile, ReadsWhatItDescribes) {
  const hil::Modes modes = hil::read_modes_text(kGood, "m.modes");
  EXPECT_EQ(modes.title, "Two masses");
  EXPECT_EQ(modes.source, std::vector<std::string>{"nobody's program, version 0"});
  EXPECT_EQ(modes.frequencies_hz, Eigen::Vector2d(2.5, 40));
  ASSERT_EQ(modes.markers.size(), 1u);
  EXPECT_EQ(modes.markers[0].shape.col(1), Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(modes.markers[0].rotation.col(1), Eigen::Vector3d(0, 0.2, 0));
  ASSERT_EQ(modes.points.size(), 2u);
  EXPECT_EQ(modes.points[1].mass, 0.5);
  EXPECT_EQ(modes.points[1].shape.col(0), Eigen::Vector3d(0, 0, 3));
}

TEST(ModesFile, WhatIsWrittenReadsBackToTheLastBit) {
  const hil::Modes modes = build_mast_modes(4, 6, Support::kFree);
  const std::string text = hil::write_modes_text(modes);
  const hil::Modes again = hil::read_modes_text(text, "m.modes");
  EXPECT_EQ(again.frequencies_hz, modes.frequencies_hz);
  ASSERT_EQ(again.points.size(), modes.points.size());
  for (std::size_t i = 0; i < modes.points.size(); ++i) {
    EXPECT_EQ(again.points[i].mass, modes.points[i].mass);
    EXPECT_EQ(again.points[i].position, modes.points[i].position);
    EXPECT_EQ(again.points[i].shape, modes.points[i].shape);
  }
  EXPECT_EQ(again.markers.at(1).rotation, modes.markers.at(1).rotation);
  EXPECT_EQ(hil::write_modes_text(again), text);
}

struct Damage {
  const char *what, *with, *says;
};
class ModesFileDamage : public ::testing::TestWithParam<Damage> {};

TEST_P(ModesFileDamage, IsRefusedWithItsPlace) {
  EXPECT_THAT(get_errors(replaced(kGood, GetParam().what, GetParam().with)), HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, ModesFileDamage,
    ::testing::Values(
        Damage{"unlatch modes 1", "unlatch modes 2", "m.modes:1:1: this is not a modes file"},
        Damage{"end\n", "", "m.modes:12:1: the file ends too early"},
        Damage{"0 0 3   0 1 0     # the lighter one\nend\n", "0 0", "m.modes:11:"},
        Damage{"0.5  -1 0 0   0 0 3   0 1 0     # the lighter one\n", "", "m.modes:11:4: 1 number; 10 belong here"},
        Damage{"1.5   1 0 0", "1.5   1 0", "9 numbers; 10 belong here"},
        Damage{"1.5   1 0 0", "1.5   1 0 0 7", "11 numbers; 10 belong here"},
        Damage{"1.5   1", "-1.5   1", "m.modes:10:1: a negative mass; lump so"},
        Damage{"1.5   1", "nan   1", "m.modes:10:1: 'nan' is not a finite number"},
        Damage{"1.5   1", "1.5D+0 1", "'1.5D+0' is not a finite number; write it like -1.25e-3"},
        Damage{"1.5   1", "1e999   1", "'1e999' is not a finite number"},
        Damage{"1.5   1", "1,5   1", "'1,5' is not a finite number"},
        Damage{"2.5 40", "-2.5 40", "m.modes:5:13: a negative frequency"},
        Damage{"2.5 40", "", "0 frequencies; 1 to 200, in Hz"},
        Damage{"frequencies 2.5 40\n", "", "shapes before frequencies"},
        Damage{"points 2", "points -2", "not a number of points"},
        Damage{"points 2", "points 1e300", "not a number of points"}, Damage{"points 2", "points 3", "10 belong here"},
        Damage{"marker tip 1", "marker 1tip 1", "'1tip' is not a name"},
        Damage{"0 0 1   0 0.5 0", "0 0 1", "3 numbers; 6 belong here: displacement and rotation of mode 1"},
        Damage{"# by hand", "nodes 3", "'nodes' begins no section; title, source"}));

TEST(ModesFile, AFolderOrNothingIsRefused) {
  EXPECT_THROW(hil::read_modes_file("/nowhere/m.modes"), hil::ScenarioError);
  EXPECT_THROW(hil::read_modes_file("/"), hil::ScenarioError);
}

}  // namespace
}  // namespace unlatch::test::modes_file_test
