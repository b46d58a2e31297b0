// Decoders of all messages in LCM's bytes: the first byte chooses the kind, the rest is the message. A decoded message
// encodes to the same bytes.
#include <algorithm>
#include <array>

#include "hil/session/messages/messages.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto kind = static_cast<hil::MessageKind>(data[0] % hil::kMessageKinds);
  const std::span bytes(data + 1, size - 1);
  hil::Message message;
  if (!hil::decode(kind, bytes, message)) return 0;
  fuzz::require(message.kind == kind, "decoded as another kind");
  (void)hil::is_well_formed(message);
  std::array<std::uint8_t, hil::kMaxWireBytes> again{};
  const std::size_t length = hil::encode(message, again);
  fuzz::require(
      std::equal(bytes.begin(), bytes.end(), again.begin(), again.begin() + static_cast<std::ptrdiff_t>(length)),
      "encoded otherwise than it was decoded");
  hil::MessageKind found{};
  (void)hil::find_kind(fuzz::to_text(data + 1, std::min<std::size_t>(size - 1, 64)), found);
  return 0;
}
