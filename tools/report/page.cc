#include "tools/report/page.h"

#include <nlohmann/json.hpp>

#include "tools/pages/embed.h"
#include "tools/pages/pages.h"

UNLATCH_EMBED_PAGE(unlatch_report_page);

namespace unlatch::tools {

std::string build_report_page(const nlohmann::ordered_json& document) {
  return build_page(UNLATCH_EMBEDDED_PAGE(unlatch_report_page), document);
}

}  // namespace unlatch::tools
