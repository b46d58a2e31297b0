// CalculiX: its input (a deck of a free shell) and its output (.frd: mesh and shapes; .dat: frequencies).
//
// Its results stand in fixed columns and run together ("0.1-1.46183E-03-6.86110E-04"): they are cut by column, never at
// white space. Shells must have been written with *NODE FILE, OUTPUT=2D, or the nodes are those of the bricks into
// which CalculiX expands them.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "tools/modes/shell_mesh.h"

namespace unlatch::tools {

// Natural modes on a mesh, rigid ones included.
struct MeshModes {
  Mesh mesh;
  std::vector<double> frequencies_hz;                       // 0 where CalculiX found ω² ≤ 0
  std::vector<std::vector<Eigen::Vector3d>> displacements;  // of each mode, at each node, m
  std::string program;                                      // "CalculiX Version 2.20"
};

// A mistake in a file of CalculiX, with its place.
class CalculixError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
// CalculiX is not there, or could not be run.
class CalculixMissing : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The deck: no supports, `modes` lowest modes.
std::string write_deck(const Mesh& mesh, const HalfShell& shell, int modes);

// Runs `ccx job` in `folder`, where job.inp is; its output goes to job.log there. Throws CalculixMissing,
// CalculixError.
void run_calculix(const std::string& program, const std::string& folder, const std::string& job);

// Frequencies from the .dat, which has more digits, or from the .frd if `dat` is empty. Throws CalculixError.
MeshModes read_calculix(const std::string& frd, const std::string& dat);
// Contents of the two files given as texts, for tests; `name`: for messages.
MeshModes parse_frd(const std::string& text, const std::string& name);
std::vector<double> parse_dat(const std::string& text, const std::string& name);  // Hz

}  // namespace unlatch::tools
