// Matrices in files that other programs read: MATLAB's (MAT version 4: MATLAB, Octave, SciPy's loadmat), NumPy's
// (.npz).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace unlatch::tools {

struct NamedMatrix {
  std::string name;  // letters, digits and _
  Eigen::MatrixXd matrix;
};
struct NamedTexts {
  std::string name;
  std::vector<std::string> texts;
};

// The whole file as bytes. Texts are a character matrix with a text a row, filled up with spaces.
std::string build_mat(const std::vector<NamedMatrix>& matrices, const std::vector<NamedTexts>& texts);

// The whole file as bytes: an archive without compression of one .npy each; texts are arrays of Unicode.
std::string build_npz(const std::vector<NamedMatrix>& matrices, const std::vector<NamedTexts>& texts);

}  // namespace unlatch::tools
