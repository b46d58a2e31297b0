// A message of ROS 2 as a type of Fast DDS.
#pragma once

#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <cstring>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include "cdr.hpp"

namespace ros2_wire {

template <class Message>
class MessageType : public eprosima::fastdds::dds::TopicDataType {
 public:
  MessageType() {
    setName(kTypeName<Message>);
    m_typeSize = 4096;  // to begin with: histories grow
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    eprosima::fastcdr::FastBuffer buffer;
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    write(cdr, *static_cast<Message*>(data));
    const std::size_t size = cdr.getSerializedDataLength();
    if (size > payload->max_size) return false;
    payload->encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
    payload->length = static_cast<std::uint32_t>(size);
    std::memcpy(payload->data, buffer.getBuffer(), size);
    return true;
  }

  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
      Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
      cdr.read_encapsulation();
      Reader reader{cdr};
      visit(reader, *static_cast<Message*>(data));
      return true;
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;  // shorter than its fields
    }
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      eprosima::fastcdr::FastBuffer buffer;
      Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
      write(cdr, *static_cast<Message*>(data));
      return static_cast<std::uint32_t>(cdr.getSerializedDataLength());
    };
  }

  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  static void write(Cdr& cdr, Message& message) {
    cdr.serialize_encapsulation();
    Writer writer{cdr};
    visit(writer, message);
  }
};

}  // namespace ros2_wire
