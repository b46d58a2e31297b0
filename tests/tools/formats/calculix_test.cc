// CalculiX's files, shell meshes and their masses: fixed columns, damage, exact integrals.
#include "tools/modes/calculix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "hil/scenario/flexible/flexible_body.h"
#include "tools/modes/mesh_modes.h"

namespace unlatch::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// One quadrilateral, 2 m by 1 m, two modes; numbers without blanks between them, as CalculiX prints them.
constexpr const char* kFrd = R"(    1C
    1UPGM               CalculiX
    1UVERSION           Version 2.20
    2C                             4                                     1
 -1        11-1.00000E+00-5.00000E-01 0.00000E+00
 -1        12 1.00000E+00-5.00000E-01 0.00000E+00
 -1        13 1.00000E+00 5.00000E-01 0.00000E+00
 -1       114-1.00000E+00 5.00000E-01 0.00000E+00
 -3
    3C                             1                                     1
 -1         1    9    0    1
 -2        11        12        13       114
 -3
    1PMODE                         1
  100CL  101 2.50000E+00           4                     2    1MODAL      1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -5  D2          1    2    2    0
 -5  D3          1    2    3    0
 -5  ALL         1    2    0    0    1ALL
 -1        11-1.46183E-03-6.86110E-04-2.28383E-02
 -1        12 1.46183E-03-6.86110E-04 2.28383E-02
 -1        13-1.46183E-03 6.86110E-04-2.28383E-02
 -1       114 1.46183E-03 6.86110E-04 2.28383E-02
 -3
    1PMODE                         2
  100CL  102 4.00000E+01           4                     2    1MODAL      1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -5  D2          1    2    2    0
 -5  D3          1    2    3    0
 -5  ALL         1    2    0    0    1ALL
 -1        11 1.00000E+00 0.00000E+00 0.00000E+00
 -1        12-1.00000E+00 0.00000E+00 0.00000E+00
 -1        13 1.00000E+00 0.00000E+00 0.00000E+00
 -1       114-1.00000E+00 0.00000E+00 0.00000E+00
 -3
 9999
)";

constexpr const char* kDat = R"(
     E I G E N V A L U E   O U T P U T

 MODE NO    EIGENVALUE                       FREQUENCY
                                     REAL PART            IMAGINARY PART
                           (RAD/TIME)      (CYCLES/TIME     (RAD/TIME)

      1  -0.3148821E-03   0.0000000E+00   0.0000000E+00   0.1774492E-01
      2   0.6316547E+05   0.2513274E+03   0.4000000E+02   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("test text has no '" + what + "'");
  return text.replace(at, what.size(), with);
}

std::string get_refusal(const std::string& frd) {
  try {
    parse_frd(frd, "job.frd");
    return "";
  } catch (const CalculixError& error) {
    return error.what();
  }
}

TEST(Calculix, NumbersThatRunTogetherAreCutByColumn) {
  const MeshModes modes = parse_frd(kFrd, "job.frd");
  EXPECT_EQ(modes.program, "CalculiX Version 2.20");
  ASSERT_EQ(modes.mesh.nodes.size(), 4u);
  EXPECT_EQ(modes.mesh.nodes[0], Eigen::Vector3d(-1, -0.5, 0));
  EXPECT_EQ(modes.mesh.elements.at(0).type, ElementType::kQuad4);
  EXPECT_EQ(modes.mesh.elements[0].nodes, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(modes.frequencies_hz, (std::vector<double>{2.5, 40}));
  EXPECT_EQ(modes.displacements[0][0], Eigen::Vector3d(-1.46183e-3, -6.8611e-4, -2.28383e-2));
  EXPECT_EQ(modes.displacements[1][3], Eigen::Vector3d(-1, 0, 0));
}

TEST(Calculix, FrequenciesOfTheDatAreReadRigidOnesIncluded) {
  EXPECT_EQ(parse_dat(kDat, "job.dat"), (std::vector<double>{0, 40}));
  EXPECT_THROW(parse_dat("", "job.dat"), CalculixError);
  EXPECT_THROW(parse_dat(replaced(kDat, "      2   0.6", "      3   0.6"), "job.dat"), CalculixError);
  EXPECT_THROW(parse_dat(replaced(kDat, "0.4000000E+02", "0.4000000E*02"), "job.dat"), CalculixError);
}

TEST(Calculix, DamagedFilesAreRefusedWithTheirLine) {
  EXPECT_THAT(get_refusal(replaced(kFrd, " 9999\n", "")), HasSubstr("without its last line"));
  EXPECT_THAT(get_refusal(std::string(kFrd).substr(0, std::string(kFrd).find(" -1        13-1.46"))),
              HasSubstr("the file ends before"));
  EXPECT_THAT(get_refusal(replaced(kFrd, "-1.46183E-03", " 1.4618NE-03")),
              HasSubstr("job.frd:21: columns 14 to 25 hold '1.4618NE-03'"));
  EXPECT_THAT(get_refusal(replaced(kFrd, "-6.86110E-04-2.28383E-02", " -6.86110E-04-2.28383E-02")),
              HasSubstr("job.frd:21: columns"));  // one blank shifts all columns
}

TEST(Calculix, WhatIsNoShellIsRefused) {
  EXPECT_THAT(get_refusal(replaced(kFrd, " -1         1    9", " -1         1    4")),
              HasSubstr("an element of type 4; shells"));
  EXPECT_THAT(get_refusal(replaced(kFrd, "                                     1\n -1        11",
                                   "                                     0\n -1        11")),
              HasSubstr("not the ASCII format 1"));
  EXPECT_THAT(get_refusal(replaced(kFrd, "        12        13       114", "        12        13       115")),
              HasSubstr("there is no node 115"));
  EXPECT_THAT(get_refusal(replaced(kFrd, " -1       114 1.46183E-03 6.86110E-04 2.28383E-02\n", "")),
              HasSubstr("a mode shape at 3 of 4 nodes"));
}

TEST(Calculix, OneThatIsNotThereIsSaidToBeMissing) {
  EXPECT_THROW(run_calculix("/nowhere/ccx", "/tmp", "job"), CalculixMissing);
}

// --- Meshes and masses ----------------------------------------------------------------------------------------------

// Any single element of a flat plate: its area, and a linear field, are exact.
TEST(MeshModes, EveryElementIntegratesItsAreaAndALinearField) {
  const std::vector<Eigen::Vector3d> corners{{0, 0, 1}, {2, 0.3, 1}, {2.5, 1.4, 1}, {-0.2, 1, 1}};
  constexpr double kQuadArea = 2.415, kTriangleArea = 1.025;  // by the shoelace formula
  for (const ElementType type :
       {ElementType::kTriangle3, ElementType::kTriangle6, ElementType::kQuad4, ElementType::kQuad8}) {
    const bool quad = type == ElementType::kQuad4 || type == ElementType::kQuad8;
    const std::size_t count = quad ? 4 : 3;
    MeshModes found;
    found.mesh.nodes.assign(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(count));
    if (type == ElementType::kTriangle6 || type == ElementType::kQuad8)
      for (std::size_t i = 0; i < count; ++i) found.mesh.nodes.push_back(0.5 * (corners[i] + corners[(i + 1) % count]));
    Element element;
    element.type = type;
    for (std::size_t i = 0; i < found.mesh.nodes.size(); ++i) element.nodes.push_back(static_cast<int>(i));
    found.mesh.elements = {element};
    found.frequencies_hz = {1};
    const Eigen::Matrix3d slope = Eigen::Vector3d(1, 2, 3) * Eigen::RowVector3d(0.5, -1, 0.25);
    found.displacements.emplace_back();
    for (const Eigen::Vector3d& node : found.mesh.nodes) found.displacements[0].push_back(slope * node);
    const hil::Modes modes = build_modes(found, 10, 0.1, 0, 12, {{"corner", {2.4, 1.5, 1}}});
    double mass = 0;
    for (const hil::ModalPoint& point : modes.points) {
      EXPECT_GT(point.mass, 0);
      mass += point.mass;
      EXPECT_LT((point.shape.col(0) - slope * point.position).norm(), 1e-10);  // rounding to twelve digits
    }
    EXPECT_NEAR(mass, 10 * (quad ? kQuadArea : kTriangleArea), 1e-9);
    EXPECT_EQ(modes.markers[0].position, corners[2]);
  }
}

TEST(MeshModes, AMarkerTurnsWithARigidMotion) {
  MeshModes found = parse_frd(kFrd, "job.frd");
  const Eigen::Vector3d turn(0.3, -0.2, 0.7);
  for (std::size_t i = 0; i < 4; ++i) found.displacements[0][i] = turn.cross(found.mesh.nodes[i]) + turn;
  const hil::Modes modes = build_modes(found, 1, 0.1, 1, 15, {{"m", {1, 1, 0}}});
  EXPECT_LT((modes.markers[0].rotation.col(0) - turn).norm(), 1e-12);
  EXPECT_LT((modes.markers[0].shape.col(0) - turn - turn.cross(Eigen::Vector3d(1, 0.5, 0))).norm(), 1e-12);
}

// Closed form of a half cylinder and half a cone, each with its own mass: means of y, z, their squares and r².
TEST(MeshModes, TheFairingHalfHasItsMassProperties) {
  constexpr double kChords = 1e-4;                      // error of 24 quadratic elements around, and a nose of 10 mm
  constexpr double kPi = std::numbers::pi, kWall = 40;  // kg/m²
  const double cylinder = kWall * kPi * 2 * 8, cone = kWall * kPi * std::sqrt(40.0), mass = cylinder + cone;
  const Eigen::Vector3d centre(0, (cylinder * 4 / kPi + cone * 8 / (3 * kPi)) / mass,
                               (cylinder * 4 + cone * 10) / mass);
  const double across = cylinder * (2 + 64.0 / 3) + cone * (1 + 102), along = cylinder * 4 + cone * 2;
  const HalfShell shell;
  MeshModes found{build_half_shell(shell), {1}, {}, ""};
  found.displacements.emplace_back();
  for (const Eigen::Vector3d& node : found.mesh.nodes)
    found.displacements[0].emplace_back(std::cos(node.z()) * node.x(), node.y() * node.y(), node.z() * node.x());
  hil::FlexibleReport report;
  const hil::FlexibleStructure body =
      hil::build_flexible_body(build_modes(found, shell.thickness * shell.density, 0.1, 0, 12, {}), {}, report);
  EXPECT_NEAR(body.mass, mass, kChords * mass);
  EXPECT_LT((body.centre - centre).norm(), kChords * centre.norm());
  EXPECT_NEAR(body.inertia(0, 0), across - mass * (centre.y() * centre.y() + centre.z() * centre.z()),
              kChords * across);
  EXPECT_NEAR(body.inertia(1, 1), across - mass * centre.z() * centre.z(), kChords * across);
  EXPECT_NEAR(body.inertia(2, 2), along - mass * centre.y() * centre.y(), kChords * along);
}

TEST(MeshModes, ADeckHasEveryNodeAndElementAndNoSupport) {
  HalfShell shell;
  shell.around = 2;
  shell.cylinder_rows = 1;
  shell.cone = 0;
  const Mesh mesh = build_half_shell(shell);
  EXPECT_EQ(mesh.nodes.size(), 13u);
  EXPECT_EQ(mesh.elements.size(), 2u);
  const std::string deck = write_deck(mesh, shell, 14);
  EXPECT_THAT(deck, HasSubstr("*ELEMENT, TYPE=S8R, ELSET=SHELL\n1, 1, 3, 11, 9, 2, 7, 10, 6\n"));
  EXPECT_THAT(deck, HasSubstr("*FREQUENCY\n14\n*NODE FILE, OUTPUT=2D\nU\n"));
  EXPECT_THAT(deck, Not(HasSubstr("BOUNDARY")));
}

}  // namespace
}  // namespace unlatch::tools
