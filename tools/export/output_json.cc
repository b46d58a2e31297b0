#include "tools/export/output_json.h"

#include <nlohmann/json.hpp>

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;
using Kind = hil::Output::Kind;

// Rows that hold, and their multipliers.
void add_reaction(const hil::Output& output, const Model& model, std::span<const double> values,
                  std::span<const double> own, Json& reactions) {
  const Joint& joint = model.joints[static_cast<std::size_t>(output.subject)];
  Json& reaction = reactions[output.of];
  if (reaction.is_null()) reaction = {{"mode", ""}, {"rows", Json::array()}, {"lambda", Json::array()}};
  // The list has a joint's mode just before its force and moment.
  const std::size_t mode_at = output.first - (output.kind == Kind::kForce ? 1 : output.kind == Kind::kMoment ? 4 : 0);
  const JointMode& mode = joint.modes[static_cast<std::size_t>(values[mode_at])];
  reaction["mode"] = mode.name;
  if (output.kind == Kind::kMode) return;
  const int first = output.kind == Kind::kForce ? kX : kRotX;
  for (int k = 0; k < 3; ++k) {
    if (!has_row(mode.rows, first + k)) continue;
    reaction["rows"].push_back(kRowNames[first + k]);
    reaction["lambda"].push_back(own[static_cast<std::size_t>(k)]);
  }
}

Json to_json(std::span<const double> values) { return Json(std::vector<double>(values.begin(), values.end())); }

}  // namespace

Json build_outputs_json(const hil::OutputReader& reader, const Model& model, std::span<const std::size_t> chosen,
                        std::span<const double> values) {
  Json json = {{"bodies", Json::object()},   {"reactions", Json::object()}, {"joints", Json::object()},
               {"elements", Json::object()}, {"sensors", Json::object()},   {"signals", Json::object()},
               {"channels", Json::object()}, {"clearance", Json::array()}};
  for (const std::size_t i : chosen) {
    const hil::Output& output = reader.list()[i];
    const std::span<const double> own = values.subspan(output.first, output.columns.size());
    switch (output.kind) {
      case Kind::kMode:
      case Kind::kForce:
      case Kind::kMoment:
        add_reaction(output, model, values, own, json["reactions"]);
        break;
      case Kind::kSensor:
        json["sensors"][output.of] = to_json(own);
        break;
      case Kind::kReceived:
        json["received"][output.of] = to_json(own);
        break;
      case Kind::kSignal:
        json["signals"][output.of] = own[0];
        break;
      case Kind::kCommand:
        json["channels"][output.of] = own[0];
        break;
      case Kind::kQuantity:
        json["quantities"][output.of] = own[0];
        break;
      case Kind::kClearance: {
        Json& pairs = json["clearance"];
        while (pairs.size() < static_cast<std::size_t>(output.subject)) pairs.push_back(nullptr);
        pairs.push_back(own[0]);
        break;
      }
      case Kind::kPosition:
        json["bodies"][output.of]["p"] = to_json(own);
        if (!model.bodies[static_cast<std::size_t>(output.subject)].flexible)
          json["bodies"][output.of]["modal"] = Json::array();
        break;
      default:
        json[output.group == "body"    ? "bodies"
             : output.group == "joint" ? "joints"
                                       : "elements"][output.of][output.key] =
            output.columns.size() == 1 && output.group == "element" ? Json(own[0]) : to_json(own);
    }
  }
  return json;
}

Json build_output_list_json(std::span<const hil::Output> list, std::span<const std::size_t> chosen) {
  Json json = Json::array();
  for (const std::size_t i : chosen) {
    Json columns = Json::array();
    for (const hil::Output::Column& column : list[i].columns)
      columns.push_back({{"name", column.name}, {"unit", column.unit}});
    json.push_back({{"name", list[i].name}, {"frame", list[i].frame}, {"columns", columns}});
  }
  return json;
}

}  // namespace unlatch::tools
