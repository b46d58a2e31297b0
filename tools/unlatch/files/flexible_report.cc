#include "tools/unlatch/files/flexible_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "hil/scenario/text/utf8.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Eigen::VectorXd& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

}  // namespace

void print_report(std::FILE* to, const hil::FlexibleStructure& body, const hil::FlexibleReport& report,
                  const hil::Modes& modes) {
  std::fprintf(to, "%s\n", paint(to, Colour::kBold, modes.title.empty() ? "A modes file" : modes.title).c_str());
  for (const std::string& line : modes.source) std::fprintf(to, "  %s\n", line.c_str());
  std::fprintf(to, "  %s, %.8g kg, centre of mass (%.6g, %.6g, %.6g) m\n",
               count(modes.points.size(), "mass point").c_str(), body.mass, body.centre.x(), body.centre.y(),
               body.centre.z());
  const Eigen::Matrix3d& J = body.inertia;
  std::fprintf(to, "  inertia about it %.6g %.6g %.6g kg m2; xy %.3g, xz %.3g, yz %.3g\n", J(0, 0), J(1, 1), J(2, 2),
               J(0, 1), J(0, 2), J(1, 2));
  std::fprintf(to, "  as found: orthonormal to %.2g, momenta %.2g of a rigid mode's; made so to %.2g and %.2g\n",
               report.found_gram, report.found_momentum, report.gram, report.momentum);
  if (!report.rigid.empty()) std::fprintf(to, "  left out: %s\n", count(report.rigid.size(), "rigid mode").c_str());
  std::fprintf(to, "  mode  Hz of file  Hz          same    eff. mass  %s\n",
               modes.markers.empty() ? "" : "share of the compliance at each marker, %");
  if (!modes.markers.empty()) {
    std::fprintf(to, "%47s", "");
    for (const hil::ModalMarker& marker : modes.markers) {
      const std::string_view name = hil::cut_text(marker.name, 7);
      const std::size_t blanks = 7 - std::min<std::size_t>(7, count_characters(name));
      std::fprintf(to, " %s%.*s", std::string(blanks, ' ').c_str(), static_cast<int>(name.size()), name.data());
    }
    std::fprintf(to, "\n");
  }
  std::vector<double> kept(modes.markers.size(), 0);
  for (const hil::ModeFinding& mode : report.modes) {
    std::fprintf(to, "%c %4d  %-10.5g  %-10.6g  %.5f  %-9.2g ", mode.selected ? '*' : ' ', mode.number, mode.file_hz,
                 mode.hz, mode.overlap, mode.effective_mass.maxCoeff());
    for (std::size_t i = 0; i < mode.compliance.size(); ++i) {
      std::fprintf(to, " %7.2f", 100 * mode.compliance[i]);
      if (mode.selected) kept[i] += mode.compliance[i];
    }
    std::fprintf(to, "\n");
  }
  if (!kept.empty()) {
    std::fprintf(to, "* kept%41s", "");
    for (const double share : kept) std::fprintf(to, " %7.2f", 100 * share);
    std::fprintf(to, "\n");
  }
}

Json build_json(const hil::FlexibleStructure& body, const hil::FlexibleReport& report) {
  Json modes = Json::array();
  for (const hil::ModeFinding& mode : report.modes)
    modes.push_back({{"number", mode.number},
                     {"file_hz", mode.file_hz},
                     {"hz", mode.hz},
                     {"overlap", mode.overlap},
                     {"selected", mode.selected},
                     {"effective_mass", to_json(mode.effective_mass)},
                     {"effective_inertia", to_json(mode.effective_inertia)},
                     {"compliance", mode.compliance},
                     {"angular_compliance", mode.angular_compliance}});
  Json markers = Json::object();
  for (const auto& marker : body.markers) markers[marker.name] = to_json(marker.marker.position);
  Json inertia = Json::array();
  for (Eigen::Index i = 0; i < 3; ++i) inertia.push_back(to_json(body.inertia.row(i)));
  return {{"schema", 1},
          {"mass", body.mass},
          {"centre", to_json(body.centre)},
          {"inertia", inertia},
          {"found", {{"gram", report.found_gram}, {"momentum", report.found_momentum}}},
          {"made", {{"gram", report.gram}, {"momentum", report.momentum}}},
          {"rigid", report.rigid},
          {"modes", modes},
          {"markers", markers}};
}

}  // namespace unlatch::tools
