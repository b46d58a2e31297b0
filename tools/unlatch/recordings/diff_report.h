// Result of the comparison of two recordings, as JSON.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hil/run/log_diff.h"
#include "tools/unlatch/recordings/replayed_log.h"

namespace unlatch::tools {

struct DiffReport {
  const std::array<OpenedLog, 2>& opened;
  const hil::LogDiff& diff;

  [[nodiscard]] const std::string& get_log(std::size_t k) const { return opened[k].recording.get_name(); }
  [[nodiscard]] const Model& get_model() const { return opened[0].scenario.model; }
  [[nodiscard]] double get_time(std::int64_t tick) const {
    return static_cast<double>(tick) * opened[0].recording.header.dt;
  }
};

bool has_same_bits(const hil::Two& values);
const char* get_cause_name(hil::ChangeCause cause);

nlohmann::ordered_json build_json(const DiffReport& report);
void write_json(const DiffReport& report, const std::string& target);  // as in report.h

}  // namespace unlatch::tools
