// MuJoCo's forward dynamics of a model in its initial state, loops closed by soft constraints (tree_links.h), through an
// MJCF document without shapes, contacts or actuators. Built where libmujoco-dev is installed (cmake/peers.cmake).
#pragma once

#include <memory>
#include <vector>

#include "tests/support/dense_kkt.h"
#include "tests/support/tree_links.h"

namespace unlatch::test {

class MujocoSystem {
 public:
  // Builds the document. Throws MuJoCo's error about it: it nests bodies 100 deep at most.
  explicit MujocoSystem(const Model& model, const std::vector<Wrench>& wrenches = {});
  ~MujocoSystem();

  void solve();                            // mj_forward()
  BodyAccelerations calc_accelerations();  // accelerations of the latest solve()

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace unlatch::test
