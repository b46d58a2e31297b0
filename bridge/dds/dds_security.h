// Authentication, access control and encryption by the plugins that come with Cyclone DDS; see bridge/SECURITY.md.
#pragma once

#include <dds/dds.h>

#include <string>

namespace unlatch::bridge {

// Adds to a participant's quality of service that it uses the identity in `folder` (ca.pem, identity.pem, key.pem,
// governance.p7s, permissions.p7s). Throws PortError if one of these cannot be read.
void set_dds_security(dds_qos_t* qos, const std::string& folder);

}  // namespace unlatch::bridge
