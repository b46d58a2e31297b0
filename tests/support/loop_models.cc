#include "tests/support/loop_models.h"

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/linkages.h"
#include "tests/support/small_models.h"

namespace unlatch::test {
namespace {

using Eigen::Vector3d;

const Vector3d kNormal(0, 0, 1);  // of the plane

// A model in the plane z = 0 under gravity along −y.
Model build_plane(const std::string& name) {
  Model model;
  model.name = name;
  model.gravity.uniform = {0, -1, 0};
  return model;
}
int add_bar(Model& model, const Vector3d& from, const Vector3d& to) {
  model.bodies.push_back(build_rod("bar" + std::to_string(model.bodies.size()), from, to));
  return static_cast<int>(model.bodies.size()) - 1;
}
void add_hinge(Model& model, int base, int follower, const Vector3d& point) {
  model.joints.push_back(build_hinge(model, base, follower, point, kNormal));
}
// Moves joints to the end of the list.
void move_to_end(Model& model, const std::vector<Joint>& closing) {
  model.joints.insert(model.joints.end(), closing.begin(), closing.end());
}

}  // namespace

Model build_ladder(int bays) {
  const Vector3d across(0.3, 0.9, 0);
  Model model = build_plane("ladder");
  std::vector<Joint> closing;
  int left = kNone, right = kNone;  // rails of the bay before
  for (int i = 0; i < bays; ++i) {
    const Vector3d begin(i, 0, 0), end(i + 1, 0, 0);
    const int rail = add_bar(model, begin, end), other = add_bar(model, begin + across, end + across),
              rung = add_bar(model, end, end + across);
    add_hinge(model, left, rail, begin);  // kNone is the ground
    add_hinge(model, rail, rung, end);
    add_hinge(model, right, other, begin + across);
    closing.push_back(build_hinge(model, rung, other, end + across, kNormal));
    closing.back().name = "close" + std::to_string(i);
    left = rail;
    right = other;
  }
  move_to_end(model, closing);
  return model;
}

Model build_four_bars(int linkages) {
  Model model = build_plane("four_bars");
  std::vector<Joint> closing;
  int floor = kGround;
  Vector3d left(0, 0, 0), right(1, 0, 0);
  for (int i = 0; i < linkages; ++i) {
    const Vector3d up(0.2, 0.8, 0), upper(0.1, 0.9, 0);
    const int crank = add_bar(model, left, left + up), rocker = add_bar(model, right, right + upper),
              coupler = add_bar(model, left + up, right + upper);
    add_hinge(model, floor, crank, left);
    add_hinge(model, floor, rocker, right);
    add_hinge(model, crank, coupler, left + up);
    closing.push_back(build_hinge(model, coupler, rocker, right + upper, kNormal));
    closing.back().name = "close" + std::to_string(i);
    floor = coupler;
    left += up;
    right += upper;
  }
  move_to_end(model, closing);
  return model;
}

Model build_lattice(int width, int length) {
  const Vector3d along(0.3, 1, 0), across(1, 0.1, 0);
  Model model = build_plane("lattice");
  std::vector<Joint> closing;
  const auto get_node = [&](int i, int j) -> Vector3d { return i * across + j * along; };
  const auto get_bar = [&](int i, int j, int which) { return 2 * (j * width + i) + which; };  // 0: across, 1: along
  for (int j = 0; j < length; ++j)
    for (int i = 0; i < width; ++i) {
      add_bar(model, get_node(i, j), get_node(i + 1, j));
      add_bar(model, get_node(i, j), get_node(i, j + 1));
    }
  add_hinge(model, kGround, 0, get_node(0, 0));
  for (int j = 0; j < length; ++j)
    for (int i = 0; i < width; ++i) {
      const Vector3d node = get_node(i, j);
      const int bar = get_bar(i, j, 0);
      if (i > 0) add_hinge(model, get_bar(i - 1, j, 0), bar, node);
      if (j > 0 && i == 0) add_hinge(model, get_bar(i, j - 1, 1), bar, node);
      add_hinge(model, bar, get_bar(i, j, 1), node);
      if (j > 0 && i > 0) {
        closing.push_back(build_hinge(model, get_bar(i, j - 1, 1), bar, node, kNormal));
        closing.back().name = "close" + std::to_string(closing.size());
      }
    }
  move_to_end(model, closing);
  return model;
}

Model build_pantograph_ring(int cells) {
  constexpr double kPi = 3.14159265358979323846;
  constexpr double kHalf = 0.8, kPost = 1.7, kFolded = 0.5;  // m, m; rad: of a bar from the ring's axis
  const double height = 2 * kHalf * std::cos(kFolded), side = 2 * kHalf * std::sin(kFolded);
  const double radius = side / (2 * std::sin(kPi / cells));
  const Vector3d up(0, 0, 1);
  const auto get_top = [&](int i) -> Vector3d {
    const double angle = 2 * kPi * i / cells;
    return {radius * std::cos(angle), radius * std::sin(angle), 0};
  };
  Model model;
  model.name = "ring";
  model.gravity.uniform = {0, 0, -1};
  for (int i = 0; i < cells; ++i) {
    const Vector3d a = get_top(i), b = get_top((i + 1) % cells);
    Body post = box("post" + std::to_string(i), 0.8, 0.2, 0.2, 5e-4),
         slider = box("slider" + std::to_string(i), 0.3, 2e-4, 2e-4, 2e-4);
    post.p_WB = a - 0.5 * kPost * up;
    slider.p_WB = a - height * up;
    model.bodies.push_back(post);
    model.bodies.push_back(slider);
    add_bar(model, a, b - height * up);
    add_bar(model, a - height * up, b);
  }
  const auto get = [&](int cell, int which) {
    return 4 * (cell % cells) + which;
  };  // post, slider, falling bar, rising bar
  std::vector<Joint> closing;
  Joint hold = build_hinge(model, kGround, 0, get_top(0), up);
  hold.modes = {{"held", kPointRows | kRotationRows}};
  model.joints.push_back(hold);
  for (int i = 0; i < cells; ++i) {
    const Vector3d a = get_top(i), b = get_top((i + 1) % cells), axis = (b - a).cross(up).normalized();
    const auto hinge = [&](int base, int follower, const Vector3d& point) {
      return build_hinge(model, base, follower, point, axis);
    };
    Joint slide = build_hinge(model, get(i, 0), get(i, 1), a - height * up, up);
    slide.modes = {{"slide", row_bit(kX) | row_bit(kY) | kRotationRows}};
    model.joints.push_back(slide);
    model.joints.push_back(hinge(get(i, 0), get(i, 2), a));
    model.joints.push_back(hinge(get(i, 2), get(i, 3), 0.5 * (a + b) - 0.5 * height * up));
    if (i + 1 < cells)
      model.joints.push_back(hinge(get(i, 3), get(i + 1, 0), b));
    else
      closing.push_back(hinge(get(i, 3), get(i + 1, 0), b));
    closing.push_back(hinge(get(i, 1), get(i, 3), a - height * up));
    closing.push_back(hinge(get(i, 2), get(i + 1, 1), b - height * up));
  }
  for (std::size_t k = 0; k < closing.size(); ++k) closing[k].name = "close" + std::to_string(k);
  for (std::size_t k = 0; k < model.joints.size(); ++k) model.joints[k].name = "joint" + std::to_string(k);
  move_to_end(model, closing);
  return model;
}

}  // namespace unlatch::test
