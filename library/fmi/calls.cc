#include "library/fmi/calls.h"

namespace unlatch::fmi {
namespace {

using State = std::vector<std::byte>;

}  // namespace

Status refuse(void* pointer, const char* function) noexcept {
  return with(pointer, [&](Instance& instance) { return instance.refuse(std::string(function) + " is not offered"); });
}

Status access_none(void* pointer, std::size_t count) noexcept {
  return with(pointer, [&](Instance& instance) {
    return count == 0 || instance.refuse("all variables of this FMU are of type Float64 (FMI 2.0: Real)");
  });
}

Status move(void* pointer, Instance::Phase from, Instance::Phase to, const char* call) noexcept {
  return with(pointer, [&](Instance& instance) { return instance.move(from, to, call); });
}
Status terminate(void* pointer) noexcept {
  return with(pointer, [](Instance& instance) { return instance.terminate(); });
}
Status reset(void* pointer) noexcept {
  return with(pointer, [](Instance& instance) { return instance.reset(); });
}

Status get_state(void* pointer, void** state) noexcept {
  return with(pointer, [&](Instance& instance) {
    if (state == nullptr) return instance.refuse("getting a state: null");
    auto saved = *state != nullptr ? nullptr : std::make_unique<State>();
    if (!instance.save(saved ? *saved : *static_cast<State*>(*state))) return false;
    if (saved) *state = saved.release();
    return true;
  });
}

Status set_state(void* pointer, const void* state) noexcept {
  return with(pointer, [&](Instance& instance) {
    if (state == nullptr) return instance.refuse("setting a state: null");
    const State& saved = *static_cast<const State*>(state);
    return instance.restore(saved.data(), saved.size());
  });
}

Status free_state(void* pointer, void** state) noexcept {
  return with(pointer, [&](Instance&) {
    if (state == nullptr) return true;
    delete static_cast<State*>(*state);
    *state = nullptr;
    return true;
  });
}

Status get_state_size(void* pointer, const void* state, std::size_t* size) noexcept {
  return with(pointer, [&](Instance& instance) {
    if (state == nullptr || size == nullptr) return instance.refuse("the size of a state: null");
    *size = static_cast<const State*>(state)->size();
    return true;
  });
}

Status serialize_state(void* pointer, const void* state, void* bytes, std::size_t size) noexcept {
  return with(pointer, [&](Instance& instance) {
    if (state == nullptr || bytes == nullptr || size != static_cast<const State*>(state)->size())
      return instance.refuse("serializing a state: null, or another size than that of the state");
    std::memcpy(bytes, static_cast<const State*>(state)->data(), size);
    return true;
  });
}

Status deserialize_state(void* pointer, const void* bytes, std::size_t size, void** state) noexcept {
  return with(pointer, [&](Instance& instance) {
    if (bytes == nullptr || state == nullptr) return instance.refuse("deserializing a state: null");
    const auto* const begin = static_cast<const std::byte*>(bytes);
    if (*state == nullptr) *state = new State;
    static_cast<State*>(*state)->assign(begin, begin + size);
    return true;
  });
}

}  // namespace unlatch::fmi
