#include "tools/unlatch/recordings/diff_report.h"

#include <bit>
#include <nlohmann/json.hpp>

#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

const char* get_result(const hil::LogDiff& diff) {
  if (diff.state) return "different";
  if (diff.is_damaged()) return "damaged";
  if (diff.agrees()) return "same";
  return diff.input ? "inputs" : "ends";
}

Json build_difference(const DiffReport& report, const hil::StateDifference& difference) {
  Json fields = Json::array(), inputs = Json::array(), changes = Json::array();
  for (const hil::FieldDifference& field : difference.fields) {
    fields.push_back({{"of", field.of}, {"field", field.field}, {"a", field.get_a()}, {"b", field.get_b()}});
    if (const auto ulps = field.calc_ulps()) fields.back()["ulp"] = *ulps;
  }
  const auto channel_name = [&](std::size_t i) { return report.get_model().channels[i].name; };
  for (std::size_t i = 0; i < difference.channels.size(); ++i) {
    const hil::Two& values = difference.channels[i];
    inputs.push_back(
        {{"channel", channel_name(i)}, {"a", values[0]}, {"b", values[1]}, {"same", has_same_bits(values)}});
  }
  for (const auto& side : difference.changes) {
    Json& list = changes.emplace_back(Json::array());
    for (const hil::LogChange& change : side) {
      list.push_back({{"channel", channel_name(static_cast<std::size_t>(change.channel))},
                      {"value", change.value},
                      {"cause", get_cause_name(change.cause)},
                      {"participant", change.participant},
                      {"sequence", change.sequence}});
    }
  }
  return {{"tick", difference.tick},
          {"t", report.get_time(difference.tick)},
          {"hash", {to_hex(difference.hashes[0]), to_hex(difference.hashes[1])}},
          {"fields_tick", difference.fields_tick},
          {"fields", fields},
          {"inputs", inputs},
          {"changes", changes}};
}

}  // namespace

bool has_same_bits(const hil::Two& values) {
  return std::bit_cast<std::uint64_t>(values[0]) == std::bit_cast<std::uint64_t>(values[1]);
}

const char* get_cause_name(hil::ChangeCause cause) {
  return hil::kChangeCauseNames[static_cast<std::size_t>(cause)];  // of a record that was decoded: it has one
}

nlohmann::ordered_json build_json(const DiffReport& report) {
  const hil::LogDiff& diff = report.diff;
  const hil::LogHeader& header = report.opened[0].recording.header;
  Json json = {{"schema", 1},     {"scenario", header.scenario_name}, {"result", get_result(diff)},
               {"dt", header.dt}, {"first_tick", diff.first_tick},    {"ticks_compared", diff.compared}};
  if (diff.state) json["difference"] = build_difference(report, *diff.state);
  if (diff.input) {
    json["first_input"] = {{"tick", diff.input->tick},
                           {"channel", report.get_model().channels[static_cast<std::size_t>(diff.input->channel)].name},
                           {"a", diff.input->values[0]},
                           {"b", diff.input->values[1]}};
  }
  json["logs"] = Json::array();
  for (std::size_t k = 0; k < 2; ++k) {
    const hil::LogEnding& ending = diff.endings[k];
    Json& log = json["logs"].emplace_back(Json{{"file", report.get_log(k)}, {"last_tick", ending.tick}});
    if (ending.status) log["status"] = get_status_name(*ending.status);
    if (!ending.message.empty()) log["message"] = ending.message;
    if (ending.unreproduced >= 0) log["unreproduced_from"] = ending.unreproduced;
  }
  return json;
}

void write_json(const DiffReport& report, const std::string& target) { write_json(build_json(report), target); }

}  // namespace unlatch::tools
