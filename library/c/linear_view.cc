#include "library/c/linear_view.h"

#include <utility>

namespace unlatch::library {
namespace {

std::vector<double> write_rows(const Eigen::MatrixXd& matrix) {
  std::vector<double> rows;
  rows.reserve(static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) rows.push_back(matrix(i, k));
  return rows;
}

}  // namespace

LinearView::List::List(const std::vector<hil::LinearName>& list) {
  for (const hil::LinearName& own : list) {
    names.push_back(own.name.c_str());
    units.push_back(own.unit.c_str());
  }
}

LinearView::LinearView(hil::LinearSystem system)
    : system_(std::move(system)), states_(system_.states), inputs_(system_.inputs), outputs_(system_.outputs) {
  const LinearModel& model = system_.model;
  std::size_t i = 0;
  for (const Eigen::MatrixXd* const matrix :
       {&model.A, &model.B, &model.C, &model.D, &model.A_error, &model.B_error, &model.C_error, &model.D_error})
    matrices_[i++] = write_rows(*matrix);
  view_ = {.time = system_.time,
           .state_count = states_.names.size(),
           .input_count = inputs_.names.size(),
           .output_count = outputs_.names.size(),
           .states = states_.names.data(),
           .state_units = states_.units.data(),
           .inputs = inputs_.names.data(),
           .input_units = inputs_.units.data(),
           .outputs = outputs_.names.data(),
           .output_units = outputs_.units.data(),
           .a = matrices_[0].data(),
           .b = matrices_[1].data(),
           .c = matrices_[2].data(),
           .d = matrices_[3].data(),
           .a_error = matrices_[4].data(),
           .b_error = matrices_[5].data(),
           .c_error = matrices_[6].data(),
           .d_error = matrices_[7].data()};
  for (const hil::Pole& pole : system_.poles) {
    poles_.insert(poles_.end(), {pole.value.real(), pole.value.imag()});
    poles_error_.push_back(pole.error);
  }
  response_ = {.pole_count = system_.poles.size(),
               .poles = poles_.data(),
               .gains = nullptr,
               .gains_error = nullptr,
               .poles_error = poles_error_.data()};
  gains_[0] = write_rows(system_.gains.values);
  gains_[1] = write_rows(system_.gains.errors);
  response_.gains = gains_[0].data();
  response_.gains_error = gains_[1].data();
}

}  // namespace unlatch::library
