#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

void add_joint_findings(const Model& model, std::vector<Finding>& findings) {
  constexpr double kBranch = 1e-6, kApart = 1e-6;  // rad; m
  for (const Joint& joint : model.joints) {
    const RowSet rows = joint.modes[at(joint.mode)].rows;
    for (int axis = 0; axis < 3; ++axis) {
      const double angle = calc_start(model, joint, kRotX + axis);
      const auto others = static_cast<RowSet>(kRotationRows & static_cast<RowSet>(~row_bit(kRotX + axis)));
      if ((rows & kRotationRows) != others || std::numbers::pi - std::abs(angle) > kBranch) continue;
      findings.push_back(
          {"branch", quoted("joint", joint.name),
           format("begins within 1e-6 rad of half a turn from its zero: rounding picks whether its angle "
                  "is +pi or -pi, here %+.9g rad; begin a little to one side, or take another zero",
                  angle)});
    }
    const std::array<double, 3> gap{calc_start(model, joint, kX), calc_start(model, joint, kY),
                                    calc_start(model, joint, kZ)};
    double apart = 0;
    for (int row = kX; row <= kZ; ++row)
      if (has_row(rows, row)) apart = std::max(apart, std::abs(gap[at(row)]));
    if (apart > kApart)
      findings.push_back({"points", quoted("joint", joint.name),
                          format("its points do not meet: %.6g, %.6g, %.6g m apart along its x, y, z; it holds them so",
                                 gap[0], gap[1], gap[2])});
  }
}

}  // namespace unlatch::hil
