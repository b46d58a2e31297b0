// Cyclone DDS keeps one domain object per process and number; the ports that use it share it here.
#pragma once

#include <dds/dds.h>

#include <memory>

#include "bridge/core/port.h"

namespace unlatch::bridge {

// A DDS entity that is deleted with its owner; its children go with it.
class DdsEntity {
 public:
  DdsEntity() = default;
  explicit DdsEntity(dds_entity_t handle) : handle_(handle) {}
  ~DdsEntity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  DdsEntity(const DdsEntity&) = delete;
  DdsEntity& operator=(const DdsEntity&) = delete;

  [[nodiscard]] dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

// The domain with our configuration, for as long as the result lives; null when the user configures Cyclone himself
// through CYCLONEDDS_URI. Throws PortError.
[[nodiscard]] std::shared_ptr<const DdsEntity> open_dds_domain(const DdsOptions& options);

// The message when Cyclone refuses: `what` did not work, for the reason in `code`.
[[nodiscard]] PortError make_dds_error(const DdsOptions& options, const char* what, dds_return_t code);

}  // namespace unlatch::bridge
