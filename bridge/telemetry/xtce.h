// The packets of a session as XTCE (OMG XML Telemetric and Command Exchange 1.2, CCSDS 660.0-B-2), for control rooms
// such as Yamcs and COSMOS. Written from the schema of the messages (message_fields.h) and the session's catalog: a
// parameter for each number, with its unit, and a container for each packet (space_packets.h). The same layout gives
// the same bytes.
#pragma once

#include <string>

#include "bridge/telemetry/session_layout.h"

namespace unlatch::bridge {

// The layout must be complete.
std::string write_xtce(const SessionLayout& layout);

}  // namespace unlatch::bridge
