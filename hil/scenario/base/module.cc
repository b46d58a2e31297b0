#include "hil/scenario/base/module.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <string>

namespace unlatch::hil {
namespace {

namespace fs = std::filesystem;

// Path of the shared library that contains this code; empty if it is the program itself.
fs::path find_own_library() {
  Dl_info info{};
  void* own = nullptr;
  if (dladdr1(reinterpret_cast<const void*>(&find_in_module), &info, &own, RTLD_DL_LINKMAP) == 0) return {};
  return static_cast<const link_map*>(own)->l_name;  // the program's name is empty
}

// Path of the module's file: relative to the program as UNLATCH_MODULES says; or, for a shared library, in the folder
// `unlatch` beside it, or beside it, as for a module.
fs::path find_file(const std::string& file) {
  std::error_code unreadable;
  const fs::path library = find_own_library();
  if (library.empty()) {
    const fs::path program = fs::read_symlink("/proc/self/exe", unreadable);
    return (program.parent_path() / UNLATCH_MODULES / file).lexically_normal();
  }
  const fs::path folder = fs::weakly_canonical(library, unreadable).parent_path();
  const fs::path below = folder / "unlatch" / file;
  return fs::exists(below, unreadable) ? below : folder / file;
}

}  // namespace

void* find_in_module(const char* module, const char* function) {
  const std::string path = find_file(std::string("lib") + module + ".so").string();
  // RTLD_LOCAL separates the symbols of the program and of the modules: each has its own copy of its static libraries.
  void* const handle = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  void* const found = handle != nullptr ? dlsym(handle, function) : nullptr;
  if (found == nullptr) throw ModuleError(std::string("a part of this program cannot be loaded: ") + dlerror());
  return found;
}

}  // namespace unlatch::hil
