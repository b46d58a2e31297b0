// Quantities with units: valid ones have the nearest bits, invalid ones give a reason.
#include "hil/scenario/text/expression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hil/scenario/text/utf8.h"
#include "tests/hil/scenario/scenario_support.h"
#include "unlatch/elementary.h"

namespace unlatch::test::expression_test {
namespace {

using hil::evaluate_expression;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const hil::Constants kConstants{{"radius", {1.32, hil::dimension_of("m")}}, {"half", {0.5, {}}}};

double value(const std::string& text) { return evaluate_expression(text, kConstants).value; }

std::string unit(const std::string& text) {
  return hil::describe_dimension(evaluate_expression(text, kConstants).dimension);
}

std::string error_of(const std::string& text) {
  try {
    evaluate_expression(text, kConstants);
    return "";
  } catch (const hil::ExpressionError& e) {
    return std::string(e.what()) + "; " + e.mend;
  }
}

TEST(Expression, NumbersWithUnitsAreTheNearestDoubles) {
  EXPECT_EQ(value("12 ms"), 0.012);
  EXPECT_EQ(value("4.38 t"), 4380);
  EXPECT_EQ(value("87 mrad"), 0.087);
  EXPECT_EQ(value("-5 mm"), -0.005);
  EXPECT_EQ(value("3 N/mm"), 3000);
  EXPECT_EQ(value("9 kN m"), 9000);
  EXPECT_EQ(value("7 km3/s2"), 7e9);
  EXPECT_EQ(value("+1e3"), 1000);
  EXPECT_EQ(value(".5"), 0.5);
  EXPECT_EQ(value("2 min"), 120);
}

TEST(Expression, SymbolsBeyondAsciiAreTheUnitsAndSignsThatTheyMean) {
  EXPECT_EQ(value("90°"), value("90 deg"));
  EXPECT_EQ(unit("90°"), "an angle (rad)");
  EXPECT_EQ(value("3 °/s"), value("3 deg/s"));
  EXPECT_EQ(value("10000 µs"), 0.01);  // U+00B5
  EXPECT_EQ(value("10000 μs"), 0.01);  // U+03BC
  EXPECT_EQ(value("2 kN·m"), 2000);
  EXPECT_EQ(unit("3 kg·m²"), unit("3 kg m2"));
  EXPECT_EQ(value("−5 mm"), -0.005);
}

TEST(Expression, AQuotedCharacterIsAWholeCodePoint) {
  EXPECT_THAT(error_of("90 ½"), AllOf(HasSubstr("unexpected '½' in '90 ½'"), Not(HasSubstr("\xc2'"))));
  EXPECT_THAT(error_of("5 €"), HasSubstr("'€'"));
  EXPECT_THAT(error_of("9 µm/h"), HasSubstr("µm/h"));  // as it was written
}

TEST(Text, IsCutBetweenCodePoints) {
  EXPECT_EQ(hil::cut_text("90°", 3), "90");
  EXPECT_EQ(hil::cut_text("90°", 4), "90°");
  EXPECT_EQ(hil::cut_text("€€", 5), "€");
}

TEST(Expression, ArithmeticGoesFromLeftToRight) {
  EXPECT_EQ(value("2*pi/3 rad"), 2 * M_PI / 3);
  EXPECT_EQ(unit("2*pi/3 rad"), "an angle (rad)");
  EXPECT_EQ(value("1/12*20 kg*(2 m)^2"), 1.0 / 12 * 20 * 4);
  EXPECT_EQ(unit("1/12*20 kg*(2 m)^2"), "a moment of inertia (kg m2)");
  EXPECT_EQ(value("-2^2"), -4);
  EXPECT_EQ(value("2*-3 - -1"), -5);
  EXPECT_EQ(value("2^-1"), 0.5);
  EXPECT_EQ(value("-radius*half"), -0.66);
  EXPECT_EQ(unit("10 m / (2 s)"), "a speed (m/s)");
  EXPECT_EQ(unit("9.81 m/s^2"), "an acceleration (m/s2)");
  EXPECT_EQ(unit("sqrt(4 m2)"), "a length (m)");
  EXPECT_EQ(value("300 kN / 0.84"), 300e3 / 0.84);
}

TEST(Expression, FunctionsAreTheKernels) {
  EXPECT_EQ(value("sin(60 mrad)"), elementary::sin(0.06));
  EXPECT_EQ(value("cos(90 deg)"), elementary::cos(90.0 / 180 * M_PI));
  EXPECT_EQ(value("atan2(1, -1)"), elementary::atan2(1, -1));
  EXPECT_EQ(unit("atan2(1 mm, 1 m)"), "an angle (rad)");
  constexpr double kRounding = 1e-15;
  EXPECT_NEAR(value("asin(0.5)"), M_PI / 6, kRounding);
  EXPECT_NEAR(value("acos(-1)"), M_PI, kRounding);
  EXPECT_NEAR(value("tan(45 deg)"), 1, kRounding);
}

// SI often omits radians.
TEST(Expression, RadiansMayBeLeftOutButNotPutWhereNoneBelong) {
  EXPECT_TRUE(hil::dimension_of("rad/s").takes(evaluate_expression("3 m/s / (2 m)", {}).dimension));
  EXPECT_TRUE(hil::dimension_of("N m/rad").takes(hil::dimension_of("N m")));
  EXPECT_FALSE(hil::dimension_of("").takes(hil::dimension_of("rad")));
  EXPECT_FALSE(hil::dimension_of("N m").takes(hil::dimension_of("N m/rad")));
}

TEST(Expression, UnitsOfOtherFieldsAreExact) {
  EXPECT_EQ(value("1 in"), 0.0254);
  EXPECT_EQ(value("1 ft"), 0.3048);
  EXPECT_EQ(value("1 lb"), 0.45359237);
  EXPECT_EQ(value("1 lbf"), 4.4482216152605);
  EXPECT_EQ(value("35 %"), 0.35);
  EXPECT_EQ(value("(30 + 5) % * 2"), 0.7);
  EXPECT_EQ(unit("35 %"), "a plain number");
  EXPECT_EQ(value("2 kJ"), 2000);
  EXPECT_EQ(unit("2 J"), unit("2 N m"));
  EXPECT_EQ(value("70 GPa"), 70e9);
  EXPECT_EQ(unit("70 GPa * 3 mm2"), "a force (N)");
  EXPECT_EQ(value("1/(4 kHz)"), 1.0 / 4000);
  EXPECT_TRUE(hil::dimension_of("s").takes(evaluate_expression("1/(4 kHz)", {}).dimension));
}

// 10 Hz is 62.8 rad/s, not 10.
TEST(Expression, AFrequencyIsNoAngularRate) {
  const hil::Dimension rate = hil::dimension_of("rad/s");
  EXPECT_FALSE(rate.takes(evaluate_expression("10 Hz", {}).dimension));
  EXPECT_TRUE(rate.takes(evaluate_expression("2*pi rad * 10 Hz", {}).dimension));
  EXPECT_EQ(unit("10 Hz"), "a frequency (Hz)");
  EXPECT_THAT(errors_with("until: 1}", "until: 10 Hz}"),
              AllOf(HasSubstr("'10 Hz' is a frequency (Hz), not a time (s)"), Not(HasSubstr("pi"))));
}

TEST(Expression, ZeroHasEveryUnit) {
  EXPECT_EQ(value("2 m + 0"), 2);
  EXPECT_EQ(unit("0 + 2 m"), "a length (m)");
  EXPECT_EQ(value("0 - 2 m - 0"), -2);
  EXPECT_THAT(error_of("2 m + 1"), HasSubstr("a sum of a length (m) and a plain number"));
}

TEST(Expression, UnitsThatPeopleTryAreCorrected) {
  const std::pair<const char*, const char*> kTries[] = {
      {"3 sec", "'s'"}, {"3 KG", "'kg'"},       {"3 lbs", "'lb'"},      {"3 feet", "'ft'"},  {"3 degrees", "'deg'"},
      {"3 hz", "'Hz'"}, {"3 psi", "'lbf/in2'"}, {"3 bar", "'100 kPa'"}, {"3 h", "'60 min'"}, {"3 Newton", "'N'"}};
  for (const auto& [text, right] : kTries) EXPECT_THAT(error_of(text), HasSubstr("did you mean " + std::string(right)));
  EXPECT_THAT(error_of("10 Xy"), Not(HasSubstr("did you mean")));
}

TEST(Expression, MistakesSayWhatIsWrong) {
  EXPECT_THAT(error_of("2 m + 3 kg"), HasSubstr("a sum of a length (m) and a mass (kg)"));
  EXPECT_THAT(error_of("2 m + 3"), HasSubstr("a sum of a length (m) and a plain number"));
  EXPECT_THAT(error_of("sin(2 m)"), HasSubstr("sin takes an angle"));
  EXPECT_THAT(error_of("2 radus"),
              AllOf(HasSubstr("neither a unit nor a constant"), HasSubstr("did you mean 'radius'")));
  EXPECT_THAT(error_of("2 radius"), HasSubstr("write the product with *"));
  EXPECT_THAT(error_of("sqr(2)"), HasSubstr("did you mean 'sqrt'"));
  EXPECT_THAT(error_of("1/0"), HasSubstr("division by zero"));
  EXPECT_THAT(error_of("sqrt(-1)"), HasSubstr("not defined"));
  EXPECT_THAT(error_of("1e300*1e300"), HasSubstr("range of a double"));
  EXPECT_THAT(error_of("2^0.5"), HasSubstr("whole number"));
  EXPECT_THAT(error_of("sqrt(2 m)"), HasSubstr("sqrt of a length"));
  EXPECT_THAT(error_of(std::string(300, '1')), HasSubstr("256 bytes"));
  EXPECT_THAT(error_of(std::string(100, '(') + "1"), HasSubstr("parentheses"));
  for (const char* text :
       {"",      " ",    "(",  ")",  "1)", "(1",    "2,3",      "1..2", "1.2.3", "0x10",  "010", "2*010",
        "1_000", "1:30", "1e", "--", "m(", "sin()", "sin(1,2)", "a b",  "%",     "5 % 3", "2**3"})
    EXPECT_NE(error_of(text), "") << text;
}

TEST(Expression, AQuantityWhereAnotherBelongsIsRefusedByName) {
  EXPECT_THAT(errors_with("mass: 100", "mass: 2 m * 3"),
              AllOf(HasSubstr("s.yaml:6:11: "), HasSubstr("is a length (m), not a mass (kg)"),
                    HasSubstr("write a number in kg")));
  EXPECT_THAT(errors_with("profile: 5 kN", "profile: 5 kN m"), HasSubstr("a torque (N m), not a force (N)"));
  EXPECT_THAT(errors_with("until: 1}", "until: 30 deg}"), HasSubstr("an angle (rad), not a time (s)"));
}

TEST(Constants, AreNamedInExpressionsAndReplaced) {
  const std::string text = replaced(replaced(kGoodScenario, "mass: 100", "mass: 2 * half_mass"),
                                    "step:", "constants: {quarter: 25 kg, half_mass: 2*quarter}\nstep:");
  EXPECT_EQ(hil::load_scenario_text(text, "s.yaml").model.bodies[0].mass, 100);
  EXPECT_EQ(hil::load_scenario_text(text, "s.yaml", {"constants.quarter=30 kg"}).model.bodies[0].mass, 120);
  EXPECT_THAT(load_errors(replaced(text, "25 kg", "25 m")), HasSubstr("a length (m), not a mass (kg)"));
  EXPECT_THAT(load_errors(replaced(text, "2*quarter", "2*later")),
              HasSubstr("'later' is neither a unit nor a constant"));
  EXPECT_THAT(load_errors(replaced(text, "{quarter", "{kN: 3, quarter")),
              HasSubstr("'kN' cannot be the name of a constant"));
  EXPECT_THAT(load_errors(replaced(text, "{quarter", "{a-b: 3, quarter")), HasSubstr("- is minus"));
  EXPECT_THAT(load_errors(replaced(text, "constants:", "quantities: {m: {expression: time}}\nconstants:")),
              HasSubstr("'m' cannot be the name of a quantity"));
}

TEST(Constants, ChannelsHaveTheirUnit) {
  const std::string text = replaced(kGoodScenario, "{initial: 1, range: [0, 1], safe: 0}",
                                    "{initial: 5 deg, range: [-20 deg, 20 deg], unit: rad}");
  EXPECT_EQ(hil::load_scenario_text(text, "s.yaml").model.channels[0].maximum, 20.0 / 180 * M_PI);
  EXPECT_THAT(load_errors(replaced(text, "initial: 5 deg", "initial: 5 m")),
              HasSubstr("a length (m), not an angle (rad)"));
}

}  // namespace
}  // namespace unlatch::test::expression_test
