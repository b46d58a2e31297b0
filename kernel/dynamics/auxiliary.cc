#include "kernel/dynamics/auxiliary.h"

#include <algorithm>

namespace unlatch {

void load_extras(const State& state, Workspace& ws) noexcept {
  std::copy(state.extras.begin(), state.extras.end(), ws.extras.now.begin());
}

void store_extras(const Workspace& ws, State& state) noexcept {
  std::copy(ws.extras.now.begin(), ws.extras.now.end(), state.extras.begin());
}

void keep_extras(Workspace& ws) noexcept {
  const Extras& e = ws.extras;
  std::copy(e.now.begin(), e.now.end(), e.start.begin());
  std::copy(e.rate.begin(), e.rate.end(), e.first.begin());
}

void begin_extras(Workspace& ws, double weight, double h) noexcept {
  const Extras& e = ws.extras;
  for (std::size_t i = 0; i < e.now.size(); ++i) {
    e.sum[i] = weight * e.first[i];
    e.now[i] = e.start[i] + h * e.first[i];
  }
}

void advance_extras(Workspace& ws, double weight, double h) noexcept {
  const Extras& e = ws.extras;
  for (std::size_t i = 0; i < e.now.size(); ++i) {
    e.sum[i] += weight * e.rate[i];
    e.now[i] = e.start[i] + h * e.rate[i];
  }
}

void finish_extras(Workspace& ws, double weight, double h) noexcept {
  const Extras& e = ws.extras;
  for (std::size_t i = 0; i < e.now.size(); ++i) {
    e.sum[i] += weight * e.rate[i];
    e.now[i] = e.start[i] + h * e.sum[i];
  }
}

void restart_extras(Workspace& ws) noexcept {
  std::copy(ws.extras.start.begin(), ws.extras.start.end(), ws.extras.now.begin());
}

void begin_second_extras(Workspace& ws, double h) noexcept {
  const Extras& e = ws.extras;
  for (std::size_t i = 0; i < e.now.size(); ++i) {
    e.sum[i] = 0.5 * e.rate[i];
    e.now[i] = e.start[i] + h * e.rate[i];
  }
}

}  // namespace unlatch
