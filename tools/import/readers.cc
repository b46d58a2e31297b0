// Module unlatch-import: the readers of others' files, with the libraries that they need.
#include "tools/import/imported.h"

extern "C" const unlatch::tools::ImportReaders* unlatch_get_import_readers() {
#ifdef UNLATCH_MUJOCO
  static constexpr unlatch::tools::ImportReaders kReaders{unlatch::tools::read_urdf, unlatch::tools::read_mjcf};
#else
  static constexpr unlatch::tools::ImportReaders kReaders{unlatch::tools::read_urdf, nullptr};
#endif
  return &kReaders;
}
