// An FMU's binary, loaded: one instance for co-simulation, whatever the version of FMI. Its code runs in this process;
// what it returns is checked, what it does to memory cannot be.
#pragma once

#include <memory>
#include <string>

#include "tools/fmu/description.h"

namespace unlatch::fmu {

// All throw FmuError: the function's name, its status, and what the FMU logged.
class CoSimulation {
 public:
  virtual ~CoSimulation() = default;

  virtual void enter_initialization(double start) = 0;  // s
  virtual void exit_initialization() = 0;
  virtual void set(const Variable& variable, double value) = 0;
  [[nodiscard]] virtual double get(const Variable& variable) = 0;
  virtual void step(double time, double size) = 0;  // s
  // As Binary::take_warning().
  [[nodiscard]] virtual std::string take_warning() = 0;
};

// `library`: the binary's path; `resources`: path of the folder of this name.
std::unique_ptr<CoSimulation> load_fmi2(const Description& description, const std::string& library,
                                        const std::string& resources);
std::unique_ptr<CoSimulation> load_fmi3(const Description& description, const std::string& library,
                                        const std::string& resources);

}  // namespace unlatch::fmu
