// A linear model in the form of unlatch.h: names as pointers, matrices by rows.
#pragma once

#include <vector>

#include "hil/run/linear/linearization.h"
#include "library/include/unlatch.h"

namespace unlatch::library {

class LinearView {
 public:
  explicit LinearView(hil::LinearSystem system);
  LinearView(const LinearView&) = delete;
  LinearView& operator=(const LinearView&) = delete;

  [[nodiscard]] const unlatch_linear_model& get() const { return view_; }
  [[nodiscard]] const unlatch_linear_response& get_response() const { return response_; }
  [[nodiscard]] const hil::LinearSystem& get_system() const { return system_; }

 private:
  using Names = std::vector<const char*>;
  struct List {
    Names names, units;
    explicit List(const std::vector<hil::LinearName>& list);
  };

  hil::LinearSystem system_;
  List states_, inputs_, outputs_;
  std::vector<double> matrices_[8], poles_, poles_error_, gains_[2];
  unlatch_linear_model view_;
  unlatch_linear_response response_;
};

}  // namespace unlatch::library
