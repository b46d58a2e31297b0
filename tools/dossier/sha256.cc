#include "tools/dossier/sha256.h"

#include <glib.h>

#include <memory>
#include <new>

namespace unlatch::tools {

std::string calc_sha256(const std::string& text) {
  const std::unique_ptr<gchar, void (*)(gpointer)> sum(
      g_compute_checksum_for_string(G_CHECKSUM_SHA256, text.data(), static_cast<gssize>(text.size())), g_free);
  if (!sum) throw std::bad_alloc();
  return sum.get();
}

}  // namespace unlatch::tools
