#include "hil/modules/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>

namespace unlatch::hil {

void* find_in_module(const char* module, const char* function) {
  std::error_code unreadable;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unreadable);
  const std::string path =
      (program.parent_path() / UNLATCH_MODULES / (std::string("lib") + module + ".so")).lexically_normal().string();
  // Names of the program and of other modules stay apart: each has its own copy of the static libraries that it needs.
  void* const handle = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  void* const found = handle != nullptr ? dlsym(handle, function) : nullptr;
  if (found == nullptr) throw ModuleError(std::string("a part of this program cannot be loaded: ") + dlerror());
  return found;
}

}  // namespace unlatch::hil
