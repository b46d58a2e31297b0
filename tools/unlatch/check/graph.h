// A model as a drawing: bodies, joints with their modes, elements, and the events between modes.
#pragma once

#include <stdexcept>
#include <string>

#include "unlatch/plan.h"

namespace unlatch::tools {

// The plan's graph in the DOT language of graphviz.
std::string describe_graph(const Model& model, const Plan& plan, const std::string& title);

// graphviz is missing or failed, or the file cannot be written.
class GraphError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Runs graphviz' `dot`, without a shell. Throws GraphError.
void draw_graph(const std::string& dot, const std::string& svg_path);

}  // namespace unlatch::tools
