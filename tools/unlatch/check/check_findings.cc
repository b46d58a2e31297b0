#include "tools/unlatch/check/check_findings.h"

#include <nlohmann/json.hpp>

#include "tools/common/alike.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {

using Json = nlohmann::ordered_json;

void print_springs(std::FILE* to, const std::vector<hil::SpringStart>& springs) {
  if (springs.empty()) return;
  print_heading(to, "Springs at the start (m, N, J; of rotations rad, N m)");
  std::fprintf(to, "  %-20s %-13s %12s %12s %12s %12s\n", "", "", "length", "force", "energy", "stroke");
  FoldedList list;
  for (const hil::SpringStart& spring : springs)
    list.add(spring.name,
             format("%-13s %12.6g %12.6g %12.6g %12.6g%s", spring.start.kind, spring.start.length, spring.start.force,
                    spring.start.energy, spring.start.stroke, spring.on ? "" : "  not enabled yet"));
  list.print(to, 20);
}

Json build_springs_json(const std::vector<hil::SpringStart>& springs) {
  Json list = Json::array();
  for (const hil::SpringStart& spring : springs) {
    list.push_back({{"name", spring.name},
                    {"kind", spring.start.kind},
                    {"enabled", spring.on},
                    {"angular", spring.angular},
                    {"length", spring.start.length},
                    {"force", spring.start.force},
                    {"energy", spring.start.energy},
                    {"stroke", spring.start.stroke}});
  }
  return list;
}

}  // namespace unlatch::tools
