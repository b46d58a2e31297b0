// Files of triangles, and meshes in scenarios.
#include "hil/scenario/shapes/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>
#include <set>

#include "hil/scenario/scenario_tree.h"
#include "tests/hil/scenario/mesh_support.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::mesh_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const Facets kBox = build_box_facets({1, 2, 3});

std::string read_errors(const std::string& bytes, const std::string& name) {
  try {
    (void)hil::read_mesh(bytes, name);
    return "";
  } catch (const hil::MeshError& error) {
    return error.what();
  }
}

TEST(MeshFile, BinaryAndAsciiStlAndObjGiveTheSameMesh) {
  const hil::MeshData binary = hil::read_mesh(write_binary_stl(kBox), "box.stl");
  EXPECT_EQ(binary.vertices.size(), 8U);
  EXPECT_EQ(binary.triangles.size(), 12U);
  for (const auto& [text, name] :
       {std::pair(write_ascii_stl(kBox), "box.STL"), std::pair(write_obj(kBox), "box.obj")}) {
    const hil::MeshData mesh = hil::read_mesh(text, name);
    EXPECT_EQ(mesh.vertices, binary.vertices) << name;
    EXPECT_EQ(mesh.triangles, binary.triangles) << name;
  }
}

TEST(MeshFile, KeywordsOfStlMayBeInCapitals) {
  std::string text = write_ascii_stl(kBox);
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  EXPECT_EQ(hil::read_mesh(text, "box.stl").triangles.size(), 12U);
}

TEST(MeshFile, ABinaryStlMayBeginLikeAnAsciiOne) {
  std::string bytes = write_binary_stl(kBox);
  bytes.replace(0, 10, "solid cube");
  EXPECT_EQ(hil::read_mesh(bytes, "box.stl").triangles.size(), 12U);
}

TEST(MeshFile, FacesOfObjMayHaveManyCornersTexturesAndNormals) {
  const hil::MeshData mesh = hil::read_mesh(
      "mtllib a.mtl\nv 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 1.5 1 0\nv 1 2 0\nv +0 2 0\nvt 0 0\nvn 0 0 1\n"
      "usemtl red\ns off\nf 1/1/1 2/1/1 3/1/1 4/1/1 5/1/1\nf 1//1 3//1 2//1\n",
      "a.obj");
  EXPECT_EQ(mesh.vertices.size(), 5U);
  EXPECT_EQ(mesh.triangles.size(), 4U);  // a fan of three, and one
}

TEST(MeshFile, TrianglesWithoutAreaAreLeftOut) {
  const hil::MeshData mesh = hil::read_mesh("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\nf 1 2 4\n", "a.obj");
  EXPECT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.vertices.size(), 3U);
}

TEST(MeshFile, DamagedFilesAreRefusedWithAReason) {
  const std::string stl = write_binary_stl(kBox), ascii = write_ascii_stl(kBox);
  EXPECT_THAT(read_errors(stl.substr(0, stl.size() - 7), "a.stl"),
              AllOf(HasSubstr("677 bytes"), HasSubstr("12 triangles would take 684"), HasSubstr("cut short")));
  std::string absurd = stl;
  absurd.replace(80, 4, "\xff\xff\xff\xff");
  EXPECT_THAT(read_errors(absurd, "a.stl"), HasSubstr("4294967295 triangles would take 214748364834"));
  Facets bad = kBox;
  bad[3].b.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(read_errors(write_binary_stl(bad), "a.stl"), HasSubstr("triangle 4: a coordinate is not finite"));
  EXPECT_THAT(read_errors(write_ascii_stl(bad), "a.stl"), AllOf(HasSubstr("line 26"), HasSubstr("nan' is not finite")));
  EXPECT_THAT(read_errors(ascii.substr(0, ascii.size() / 2), "a.stl"), HasSubstr("line 4"));
  EXPECT_THAT(read_errors(write_binary_stl({}), "a.stl"), HasSubstr("no triangle"));
  EXPECT_THAT(read_errors("solid a\nendsolid a\n", "a.stl"), HasSubstr("no triangle"));
  EXPECT_THAT(read_errors("", "a.stl"), HasSubstr("'solid' belongs"));
  EXPECT_THAT(read_errors("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "a.obj"), HasSubstr("line 4: corner 4 of 3"));
  EXPECT_THAT(read_errors("v 0 0 0\nv 1 0 0\nf 1 2 0\n", "a.obj"), HasSubstr("corner 0 of 2"));
  EXPECT_THAT(read_errors("v 0 0 0\nv 1 0 0\nf 1 2\n", "a.obj"), HasSubstr("line 3: a face of 2 corners"));
  EXPECT_THAT(read_errors("v 0 0\n", "a.obj"), HasSubstr("line 1: a number is missing"));
  EXPECT_THAT(read_errors("v 0 0 1e39\n", "a.obj"), HasSubstr("'1e39' is not finite in single precision"));
  EXPECT_THAT(read_errors("v 0 0 x\n", "a.obj"), HasSubstr("'x' is not a number"));
  EXPECT_THAT(read_errors("<html>\n", "a.obj"), HasSubstr("'<html>' is no keyword of OBJ"));
  EXPECT_THAT(read_errors(stl, "a.step"), HasSubstr("neither in .stl nor in .obj"));
}

TEST(MeshFile, OfTooManyCornersIsRefused) {
  std::string text;
  for (int i = 0; i < 65537; ++i) text += "v " + std::to_string(i) + " " + std::to_string(i % 3 % 2) + " 0\n";
  for (int i = 1; i <= 65535; i += 3)
    text += "f " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  EXPECT_EQ(read_errors(text, "a.obj"), "");
  EXPECT_THAT(read_errors(text + "f 65535 65536 65537\n", "a.obj"), HasSubstr("more than 65536 corners"));
}

TEST(MeshFile, TheTextOfARecordingReadsBackTheSameAndNoOther) {
  const hil::MeshData mesh = hil::read_mesh(write_binary_stl(build_sphere_facets(0.1, 24)), "a.stl");
  const std::string text = hil::write_mesh_text(mesh);
  EXPECT_TRUE(hil::is_mesh_text(text));
  const hil::MeshData again = hil::read_mesh_text(text);
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.triangles, mesh.triangles);
  const std::string counts = std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size());
  for (const std::string& damaged :
       {text.substr(0, text.size() - 5), replaced(text, counts, "1 " + std::to_string(mesh.triangles.size())),
        replaced(text, counts, "99999999999999999999 3"), replaced(text, counts, "0 0"),
        std::string("unlatch-mesh 1\n"), std::string("unlatch-mesh 2\n")})
    EXPECT_THROW((void)hil::read_mesh_text(damaged), hil::MeshError) << damaged.substr(0, 60);
}

// --- In scenarios ---------------------------------------------------------------------------------------------------

const std::string kCoreShape = "shape: [{sphere: {radius: 1}}]";

// A folder with a scenario whose core is a mesh.
class MeshScenario : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("mesh-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_ / "parts");
    write_file(path("parts/box.stl"), write_binary_stl(build_box_facets({1000, 2000, 3000})));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  hil::Scenario load(const std::string& text) const {
    write_file(path("s.yaml"), text);
    return hil::load_scenario(path("s.yaml"));
  }
  std::string load_errors(const std::string& text) const {
    try {
      (void)load(text);
      return "";
    } catch (const hil::ScenarioError& error) {
      return error.what();
    }
  }
  static std::string with_mesh(const std::string& mesh, const std::string& more = "") {
    return replaced(kGoodScenario, kCoreShape,
                    "shape: [{name: hull, mesh: {" + mesh + "}}, {name: tank, sphere: {radius: 1}}]") +
           more;
  }

  std::filesystem::path folder_;
};

TEST_F(MeshScenario, PlacesItsMeshInTheBody) {
  const hil::Scenario scenario =
      load(with_mesh("file: parts/box.stl, scale: 1 mm, origin: [10 cm, 0, 0], attitude: {rotate: [[z, 90 deg]]}"));
  const hil::TriangleMesh& mesh = *scenario.shapes[0].at(0).mesh;
  EXPECT_EQ(mesh.get_triangles().size(), 12U);
  EXPECT_NEAR(mesh.get_centre().x, 0.1, 1e-12);
  EXPECT_NEAR(mesh.get_bound(), std::sqrt(14.0), 1e-12);
  for (const Vec3& p : mesh.get_vertices()) {
    EXPECT_NEAR(std::abs(p.x - 0.1), 2, 1e-12);
    EXPECT_NEAR(std::abs(p.y), 1, 1e-12);
  }
  EXPECT_EQ(scenario.clearance.at(0).a.shapes.size(), 2U);
}

TEST_F(MeshScenario, TheTextOfItHoldsTheMesh) {
  const hil::Scenario scenario = load(with_mesh("file: parts/box.stl, scale: 1 mm"));
  std::filesystem::remove(path("parts/box.stl"));
  const hil::Scenario again = hil::load_scenario_text(scenario.text, "recorded");
  EXPECT_EQ(again.text, scenario.text);
  const auto &of_first = scenario.shapes[0].at(0).mesh->get_vertices(),
             &of_again = again.shapes[0].at(0).mesh->get_vertices();
  ASSERT_EQ(of_again.size(), of_first.size());
  for (std::size_t i = 0; i < of_first.size(); ++i) EXPECT_EQ(norm(of_again[i] - of_first[i]), 0);
  EXPECT_THAT(load_errors(with_mesh("file: parts/box.stl")), HasSubstr("there is no such file"));
}

TEST_F(MeshScenario, ReadingsOfOneTreeShareItsMesh) {
  write_file(path("s.yaml"), with_mesh("file: parts/box.stl, scale: 1 mm"));
  const hil::ScenarioTree tree(path("s.yaml"), {});
  const hil::Scenario one = tree.read({}), other = tree.read({});
  EXPECT_EQ(one.shapes[0][0].mesh, other.shapes[0][0].mesh);
  const hil::Setting larger = hil::parse_setting("bodies.core.shape.0.mesh.scale=2 mm");
  EXPECT_NEAR(tree.read({&larger, 1}).shapes[0][0].mesh->get_bound(), 2 * one.shapes[0][0].mesh->get_bound(), 1e-12);
}

TEST_F(MeshScenario, BadFilesAreRefusedAtTheirPlace) {
  write_file(path("cut.stl"), write_binary_stl(kBox).substr(0, 300));
  std::filesystem::create_directory(path("folder.stl"));
  write_file(path("giant.stl"), "");
  std::filesystem::resize_file(path("giant.stl"), (64u << 20) + 1);
  std::filesystem::create_symlink("/dev/zero", path("device.stl"));
  write_file((folder_.parent_path() / "outside.stl").string(), write_binary_stl(kBox));
  std::filesystem::create_symlink(folder_.parent_path() / "outside.stl", path("link.stl"));
  const auto expect = [&](const std::string& file, const std::string& text) {
    EXPECT_THAT(load_errors(with_mesh("file: " + file)),
                AllOf(HasSubstr("s.yaml:8:"), HasSubstr("this mesh cannot be read: " + text)));
  };
  expect("cut.stl", "it has 300 bytes");
  expect("folder.stl", "this is a folder");
  expect("giant.stl", "it has 67108865 bytes");
  expect("device.stl", "it lies outside the scenario's folder");
  expect("link.stl", "it lies outside the scenario's folder");
  expect("../outside.stl", "it lies outside the scenario's folder");
  expect("/etc/hostname", "an absolute path");
  expect("nothing.stl", "there is no such file");
  expect("s.yaml", "its name ends neither in .stl nor in .obj");
  EXPECT_THAT(load_errors(with_mesh("scale: 1 mm")), HasSubstr("mesh has no file"));
  EXPECT_THAT(load_errors(with_mesh("file: parts/box.stl, scale: 0")), HasSubstr("'scale' is out of its range"));
  EXPECT_THAT(load_errors(with_mesh("file: parts/box.stl, size: 2")), HasSubstr("unknown key 'size'"));
}

TEST_F(MeshScenario, LargerThanARecordingHoldsIsRefused) {
  write_file(path("large.stl"), write_binary_stl(build_sphere_facets(1, 330)));
  EXPECT_THAT(load_errors(with_mesh("file: large.stl")), HasSubstr("more than 1 MiB"));
}

TEST_F(MeshScenario, MeshesAreRefusedWhereTheStepNeedsADistance) {
  const std::string mesh = "file: parts/box.stl, scale: 1 mm";
  const std::string refusal = "has a mesh, parts/box.stl: contacts, conditions and sensors are between other shapes";
  for (const std::string& more : {std::string("contacts:\n  bump: {between: [core, booster], stiffness: 1e6}\n"),
                                  std::string("contacts:\n  bump: {between: [booster, core.hull], stiffness: 1e6}\n")})
    EXPECT_THAT(load_errors(with_mesh(mesh, more)), AllOf(HasSubstr(refusal), HasSubstr("as core.skirt")));
  EXPECT_THAT(
      load_errors(replaced(with_mesh(mesh), "  gyro:", "  gap: {type: distance, between: [core, booster]}\n  gyro:")),
      HasSubstr(refusal));
  EXPECT_THAT(load_errors(replaced(with_mesh(mesh), "when: {displacement: {joint: nose, axis: x}, below: -5 mm}",
                                   "when: {clearance: {between: [core, booster]}, below: 5 cm}")),
              HasSubstr(refusal));
  EXPECT_EQ(load_errors(with_mesh(mesh, "contacts:\n  bump: {between: [core.tank, booster], stiffness: 1e6}\n")), "");
}

}  // namespace
}  // namespace unlatch::test::mesh_file_test
