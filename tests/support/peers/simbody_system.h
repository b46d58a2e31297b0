// Simbody's forward dynamics of a model in its initial state, loops closed by constraints (tree_links.h). Built where libsimbody-dev is installed
// (cmake/peers.cmake).
#pragma once

#include <memory>
#include <vector>

#include "tests/support/dense_kkt.h"
#include "tests/support/tree_links.h"

namespace unlatch::test {

class SimbodySystem {
 public:
  explicit SimbodySystem(const Model& model, const std::vector<Wrench>& wrenches = {});
  ~SimbodySystem();

  void solve();  // realize(Acceleration) like after a change of positions and velocities
  void
  solve_factored();  // likewise with the articulated inertias of the latest solve(): it keeps the results for positions
  BodyAccelerations calc_accelerations() const;  // of the latest solve

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace unlatch::test
