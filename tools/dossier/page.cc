#include "tools/dossier/page.h"

#include <nlohmann/json.hpp>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED_PAGE(unlatch_dossier_page);

namespace unlatch::tools {

std::string build_dossier_page(const nlohmann::ordered_json& document) {
  return build_page(UNLATCH_EMBEDDED_PAGE(unlatch_dossier_page), document);
}

}  // namespace unlatch::tools
