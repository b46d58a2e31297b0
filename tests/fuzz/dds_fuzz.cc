// Decoders of all messages in the form of DDS: the first byte chooses the kind, the rest is a serialised sample as in a
// datagram, encapsulation included. Cyclone's own decoder makes the struct of it, as in bridge/dds/dds_port.cc.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include <array>

#include "bridge/dds/dds_domain.h"
#include "tests/fuzz/fuzz.h"
#include "unlatch.h"

using namespace unlatch;

namespace {

constexpr std::array<const dds_topic_descriptor_t*, hil::kMessageKinds> kTypes{
    &unlatch_Hello_desc,   &unlatch_Catalog_desc,   &unlatch_HelloAck_desc, &unlatch_State_desc,
    &unlatch_Command_desc, &unlatch_StepAck_desc,   &unlatch_Event_desc,    &unlatch_Health_desc,
    &unlatch_Verdict_desc, &unlatch_Reactions_desc, &unlatch_Source_desc};

dds_entity_t check(dds_entity_t result) {
  fuzz::require(result >= 0, dds_strretcode(result));
  return result;
}

// Cyclone's names of the types, from a sample that Cyclone has serialised.
class Types {
 public:
  Types() {
    bridge::DdsOptions options;
    options.domain = 77;
    domain_ = bridge::open_dds_domain(options);
    const dds_entity_t participant =
        check(dds_create_participant(static_cast<dds_domainid_t>(options.domain), nullptr, nullptr));
    for (std::size_t i = 0; i < kTypes.size(); ++i) {
      const std::string name(hil::get_kind_name(static_cast<hil::MessageKind>(i)));
      const dds_entity_t topic = check(dds_create_topic(participant, kTypes[i], name.c_str(), nullptr, nullptr));
      const dds_entity_t reader = check(dds_create_reader(participant, topic, nullptr, nullptr));
      const dds_entity_t writer = check(dds_create_writer(participant, topic, nullptr, nullptr));
      const hil::Message zero;
      check(dds_write(writer, &zero.hello));
      dds_sample_info_t info;
      fuzz::require(dds_takecdr(reader, &samples_[i], 1, &info, DDS_ANY_STATE) == 1, "no sample");
    }
  }
  [[nodiscard]] const ddsi_sertype* get(std::size_t kind) const { return samples_[kind]->type; }

 private:
  std::shared_ptr<const bridge::DdsEntity> domain_;
  std::array<ddsi_serdata*, hil::kMessageKinds> samples_{};
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Types& types = *new Types;    // Cyclone's threads outlive the target
  constexpr std::size_t kEncapsulation = 4;  // shorter input is refused before decoding
  if (size < 1 + kEncapsulation) return 0;
  const std::size_t kind = data[0] % hil::kMessageKinds;
  const ddsrt_iovec_t bytes{const_cast<std::uint8_t*>(data) + 1, size - 1};
  ddsi_serdata* const serdata = ddsi_serdata_from_ser_iov(types.get(kind), SDK_DATA, 1, &bytes, size - 1);
  if (serdata == nullptr) return 0;
  fuzz::require((data[2] & 1) != 0, "a big-endian sample was read");  // bridge/dds/dds_byte_order.cc
  // Guards on both sides: Cyclone is not compiled with a sanitizer.
  constexpr std::size_t kGuard = 64;
  constexpr std::uint8_t kUntouched = 0xA5;
  std::array<std::uint8_t, sizeof(hil::Message) + 2 * kGuard> room;
  room.fill(kUntouched);
  hil::Message message;
  if (ddsi_serdata_to_sample(serdata, room.data() + kGuard, nullptr, nullptr)) {
    const std::size_t length = hil::get_size(static_cast<hil::MessageKind>(kind));
    for (std::size_t i = 0; i < room.size(); ++i) {
      if (i >= kGuard && i < kGuard + length) continue;
      fuzz::require(room[i] == kUntouched, "a byte written outside the message");
    }
    message.kind = static_cast<hil::MessageKind>(kind);
    std::copy_n(room.data() + kGuard, length, reinterpret_cast<std::uint8_t*>(&message.hello));
    (void)hil::is_well_formed(message);
  }
  ddsi_serdata_unref(serdata);
  return 0;
}
